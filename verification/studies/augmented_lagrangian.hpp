#pragma once

#include <string>
#include <vector>

#include "verification/support/needle_in_box.hpp"

namespace finegauge {

/// What one weight of the augmented Lagrangian costs and gives.
struct WeightRow {
  double kappa = 0.0;
  bool converged = false;
  int iterations = 0, linear_iterations = 0;
  double force_error = 0.0;  ///< ‖λ - λ_KKT‖ / ‖λ_KKT‖, λ_KKT by dense LU with the same active set
  double violation = 0.0;
};
struct WeightTable {
  std::vector<WeightRow> rows;
  std::string text() const;
};
WeightTable weight_table(const NeedleInBox& box, const std::vector<double>& kappas);

/// Uzawa's convergence with bilateral rows all of weight w, by theory and as it is: the error of λ shrinks each
/// iteration by at most 1/(1 + w sigma_min), sigma the eigenvalues of J A⁻¹ Jᵀ (κ scales the rows; here W^½ J).
struct ErrorFactorRow {
  double kappa = 0.0;
  double bound = 0.0;      ///< 1/(1 + sigma_min(W^½ J A⁻¹ Jᵀ W^½))
  double generic = 0.0;    ///< largest factor of an iteration from λ = 0, in the norm of W^-½ λ
  double slowest = 0.0;    ///< factor from an error along the slowest eigenvector: the bound is attained
  double condition = 0.0;  ///< of A + Jᵀ W J, the tissue's with the needle rigid
};
std::vector<ErrorFactorRow> error_factors(NeedleInBox box, const std::vector<double>& kappas);

}  // namespace finegauge
