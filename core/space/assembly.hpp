#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/space/discretization.hpp"

namespace finegauge {

/// Reduced stiffness Tᵀ K(u) T element by element, rotations frozen at the nodal displacement u [m] (no rotations for
/// Kinematics::linear); the cells' springs are part of it. The two loops apart because the second one is what hanging
/// nodes cost. Both add to A.
void assemble_regular_cells(const Discretization& d, const Eigen::Matrix3Xd& u, BlockMatrix<double>& A);
void assemble_hanging_cells(const Discretization& d, const Eigen::Matrix3Xd& u, BlockMatrix<double>& A);
BlockMatrix<double> assemble_stiffness(const Discretization& d, const Eigen::Matrix3Xd& u);

/// A <- Z A Z + κ H with κ per node the mean of the block's diagonal.
void apply_supports(const Supports& supports, BlockMatrix<double>& A);

/// Internal forces at all nodes [N], springs with their anchors at rest included.
Eigen::Matrix3Xd internal_forces(const Discretization& d, const Eigen::Matrix3Xd& u);
/// ∫ ε:σ [J], twice the energy stored in the body, with rotations frozen at u. Springs are not part of it
/// (spring_energy).
double strain_energy_product(const Discretization& d, const Eigen::Matrix3Xd& u);

/// The explicit unreduced stiffness, 3 n_nodes square: oracle.
Eigen::SparseMatrix<double> nodal_stiffness(const Discretization& d, const Eigen::Matrix3Xd& u);

}  // namespace finegauge
