#pragma once

#include <Eigen/Core>

#include "core/mesh/mesh.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// A conforming nodal field of one mesh on another mesh of the same forest. Where the new mesh is finer the field is
/// kept exactly; where it is coarser the values at the nodes that remain are kept. One change of
/// template is two transfers (mesh/nested_meshes.hpp).
Eigen::Matrix3Xd transfer(const Mesh& from, const Eigen::Matrix3Xd& nodal, const Mesh& to);

/// Reduced nodal forces on another mesh of the same forest, a column each [N]: Pᵀ f with P the values of the new mesh's
/// fields at the old nodes. Where the new mesh is coarser that is the adjoint of the interpolation, every coarse field
/// receives the work that it received; where it is finer the forces stay at the old nodes, and a fine field receives
/// the work of its values there: of coarse fields the same as before. The sum of the forces is kept.
Eigen::MatrixXd transfer_forces(const Discretization& from, const Eigen::MatrixXd& forces, const Discretization& to);

}  // namespace finegauge
