#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/solve/solve_report.hpp"
#include "core/space/block_matrix.hpp"

namespace finegauge {

/// Sparse Cholesky factorization by CHOLMOD: analyze and factor once, solve often.
class DirectSolver {
 public:
  explicit DirectSolver(const BlockMatrix<double>& A);
  ~DirectSolver();
  DirectSolver(DirectSolver&&) noexcept;
  DirectSolver& operator=(DirectSolver&&) noexcept;

  /// False when the matrix is not positive definite; solve must not be called then.
  bool factored() const;
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  double factor_nonzeros() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace finegauge
