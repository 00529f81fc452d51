#pragma once

#include "core/mesh/base_mesh.hpp"

namespace finegauge {

/// The body around an edge along the z axis: material from the angle 0, the x axis, to `opening` [rad], in `blocks`
/// equal parallelograms between rays of length one, each of n × n cells, and `layers` layers of cells up to `height`.
struct WedgeOptions {
  double opening;  ///< in (0, 2 pi]; at 2 pi the two ends have nodes of their own: a crack along the x axis
  int blocks, n, layers = 3;
  double height = 0.5;
};
/// Surfaces: `ray_first`, `ray_last` (the two faces that meet at the edge), `outer`, `z_min`, `z_max`. Throws
/// std::invalid_argument where a block's angle is not below pi.
BaseMesh wedge_mesh(const WedgeOptions& options);

}  // namespace finegauge
