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

/// Whole cells whose two faces across an axis both belong to the body's boundary (no other cell has them, and their
/// corners lie on it); `bent` of them: under u some pair of opposite edges of these faces, one in each, changes its
/// lengths more unlike than alike. Lengths do not see rotations.
struct ThroughCells {
  int through = 0, bent = 0;
};
ThroughCells through_cells(const Mesh& mesh, const Eigen::Matrix3Xd& u);

/// What the cells do to the result: standard dilatation from nu = 0.45 on, where it locks; mean dilatation where a
/// body that bends has one cell through its depth.
std::vector<std::string> cell_notes(const Scene& scene, const Mesh& mesh, const Eigen::Matrix3Xd& u);

/// What a user should hear about a result that is right as a solution and yet may not be what was meant: linear
/// kinematics where cells turn by more than 10 degrees; a scene in which nothing loads or moves the body, or only
/// where it is held; cell_notes.
std::vector<std::string> static_notes(const Scene& scene, const Discretization& d, const Eigen::Matrix3Xd& u);

}  // namespace finegauge
