#pragma once

namespace finegauge {

/// What a linear solve returns beside its solution.
struct [[nodiscard]] SolveReport {
  bool converged = false;
  int iterations = 0;
  double relative_residual = 0.0;  ///< ‖b - A x‖ / ‖b‖, the true residual, computed at the end
};

}  // namespace finegauge
