#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/mesh/mesh.hpp"

namespace finegauge {

/// A point of the body by the leaf that contains it.
struct MaterialPoint {
  int cell;            ///< of the mesh; the first of those that share the point
  Eigen::Vector3d xi;  ///< natural coordinates in the cell
};
/// None when the point lies outside the body by more than 1e-9 of a cell (rounding of the coordinates in a scene).
std::optional<MaterialPoint> locate(const Mesh& mesh, const Eigen::Vector3d& rest_position);

/// The field at the point; nodal: 3 × n_nodes.
Eigen::Vector3d interpolate(const Mesh& mesh, const MaterialPoint& point,
                            const Eigen::Ref<const Eigen::Matrix3Xd>& nodal);

}  // namespace finegauge
