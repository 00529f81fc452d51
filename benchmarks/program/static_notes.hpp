#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Rotation [rad], 0 to pi, of the cell that turns most: of the deformation gradients at the cells' centres under the
/// nodal displacement u [m], as corotational kinematics measures it, whatever the material's kinematics.
double largest_cell_rotation(const Discretization& d, const Eigen::Matrix3Xd& u);

/// What a user should hear about a result that is right as a solution and yet may not be what was meant: linear
/// kinematics where cells turn by more than 10 degrees; a scene in which nothing loads or moves the body.
std::vector<std::string> static_notes(const Scene& scene, const Discretization& d, const Eigen::Matrix3Xd& u);

}  // namespace finegauge
