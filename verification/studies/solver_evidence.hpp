#pragma once

#include <vector>

#include "core/equilibrium.hpp"
#include "verification/support/evidence.hpp"

namespace finegauge {

/// What iterations leave of the discrete equations, against dense, direct and closed solutions: the augmented
/// Lagrangian of the contact, the static solve, and backward Euler's own closed forms (dynamics.hpp). Throws
/// std::runtime_error where a solve that has to converge does not.
Evidence solver_evidence(const EvidenceOptions& options);

/// A static problem solved by multigrid to a residual asked for, against the direct solution of the same matrix.
struct AlgebraicRow {
  double asked = 0.0;  ///< relative residual
  int iterations = 0;
  double reported = 0.0;       ///< by the solver
  double true_residual = 0.0;  ///< recomputed cell by cell: ‖free (f - f_int(u))‖ / ‖free f‖
  double energy_norm = 0.0;    ///< ‖u - u_direct‖_K / ‖u_direct‖_K
  double energy_defect = 0.0;  ///< 1 - energy / energy of the direct solution: the square of the line above
};
struct AlgebraicLadder {
  int dofs = 0, hanging_nodes = 0, levels = 0;
  double condition = 0.0;  ///< of K in the free directions, extreme eigenvalues by the power method
  double round_off = 0.0;  ///< of a relative residual of cells' forces: unit round-off × ‖|K| |X|‖ over the load
  std::vector<AlgebraicRow> rows;
};
AlgebraicLadder algebraic_ladder(const std::vector<double>& asked);

}  // namespace finegauge
