#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/needle/interaction.hpp"

namespace finegauge {

/// An interaction as one dense system, oracle: dofs are the tissue's, then the needle's; rows three per point, in its
/// frame. A dv = b - Jᵀ λ, relative velocity r = v + J dv. J has no entries in held directions.
struct DenseInteraction {
  Eigen::MatrixXd A, J;
  Eigen::VectorXd b, v;
  int tissue_dofs = 0;
};
DenseInteraction dense_interaction(const InteractionSystem& system);

struct DenseSolution {
  Eigen::VectorXd dv, lambda, velocity;  ///< velocity: r, 3 P
  double residual = 0.0;                 ///< of the equilibrated system, relative
};
/// Rows that hold (J dv = rhs there) by LU with full pivoting of [[A, J_aᵀ], [J_a, 0]], equilibrated, with two steps of
/// refinement in extended precision; all other rows have the impulses `fixed`. Rows that hold must be independent.
DenseSolution solve_dense_kkt(const DenseInteraction& dense, const std::vector<bool>& holds, const Eigen::VectorXd& rhs,
                              const Eigen::VectorXd& fixed);

/// The multipliers' own system: r = r_0 - G λ.
struct Delassus {
  Eigen::MatrixXd G;  ///< J A⁻¹ Jᵀ, 3 P × 3 P
  Eigen::VectorXd r_0;
};
Delassus delassus(const DenseInteraction& dense);

/// rhs = -(J v + g/τ), no gap where the law has none.
Eigen::VectorXd target_of_rows(const InteractionSystem& system, const DenseInteraction& dense);
/// The solution with the active set and the bounds that `found` ends with.
DenseSolution solve_dense_kkt(const InteractionSystem& system, const Interaction& found);
/// All λ of an interaction, 3 P.
Eigen::VectorXd multipliers(const Interaction& found);

}  // namespace finegauge
