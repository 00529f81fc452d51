#pragma once

#include <Eigen/Core>
#include <functional>

#include "core/solve/solve_report.hpp"
#include "core/space/block_matrix.hpp"

namespace finegauge {

using Preconditioner = std::function<void(const Eigen::VectorXd& r, Eigen::VectorXd& z)>;

struct IterationLimits {
  double relative_residual = 1e-6;  ///< ‖b - A x‖ ≤ this × ‖b‖
  int iterations = 1000;
};

/// Preconditioned conjugate gradients from the x given. Reports non-convergence and breakdown; never throws for them.
SolveReport conjugate_gradients(const BlockMatrix<double>& A, const Eigen::VectorXd& b, const Preconditioner& M,
                                const IterationLimits& limits, Eigen::VectorXd& x);

}  // namespace finegauge
