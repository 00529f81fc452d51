#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

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

  /// False when a pivot is not positive or so small beside the largest that it may be round-off (the matrix is
  /// indefinite, singular, or cannot be told from that), and when the factor does not fit the memory; solve must not be
  /// called then.
  bool factored() const;
  /// Throws std::bad_alloc when the solution does not fit the memory.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  double factor_nonzeros() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Keeps the last factorization and hands it out again while the matrix is the same to the last bit, so it is never
/// stale: the coarsest matrix of a linear problem does not change while its mesh adapts.
class FactorCache {
 public:
  std::shared_ptr<const DirectSolver> factor(const BlockMatrix<double>& A);

 private:
  std::vector<int> row_start_, column_;
  std::vector<double> values_;
  std::shared_ptr<const DirectSolver> solver_;
};

}  // namespace finegauge
