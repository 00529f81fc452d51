#pragma once

#include <Eigen/Core>

#include "core/mesh/region.hpp"

/// How points are selected. Not part of the interface of the mesh.
namespace finegauge {

/// Coordinates this far outside of a selection are still in it [m]: a share of the diagonal of the points' bounding
/// box.
double selection_slack(const Eigen::Matrix3Xd& points);

/// The columns of `points` (3 × n) within `slack` [m] of the selection. Of a patch its sphere: `point` is on the
/// surface already.
Selected select_points(const Eigen::Matrix3Xd& points, const Selection& selection, double slack);

}  // namespace finegauge
