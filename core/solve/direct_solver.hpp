#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/solve/solve_report.hpp"
#include "core/space/block_matrix.hpp"

namespace finegauge {

/// Sparse Cholesky factorization by CHOLMOD: analyze and factor once, solve often. The matrix is scaled by a power of
/// two before it is factored, so that a problem in other units, all of them powers of two apart, has the same bits.
class DirectSolver {
 public:
  explicit DirectSolver(const BlockMatrix<double>& A);
  ~DirectSolver();
  DirectSolver(DirectSolver&&) noexcept;
  DirectSolver& operator=(DirectSolver&&) noexcept;

  /// Factors another matrix on the same pattern (precondition) without the analysis: the factor then has the same bits
  /// as a fresh one. Returns factored().
  [[nodiscard]] bool refactor(const BlockMatrix<double>& A);
  /// False when a pivot is not positive or so small beside the diagonal entry that it came from that it may be nothing
  /// but round-off (the matrix is indefinite, singular, or cannot be told from that), and when the factor does not fit
  /// the memory; solve must not be called then.
  bool factored() const;
  /// A⁻¹ b; B: 3 n × right sides, all at once. Throws std::bad_alloc when the solution does not fit the memory. Several
  /// threads may call solve_columns at the same time, and solve one at a time.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd solve_columns(const Eigen::MatrixXd& B) const;

  /// Smallest over the rows j of pivot_j / A_jj, in (0, 1]; 0 when a pivot is not positive. Unlike a condition number
  /// it does not see the scales of the rows.
  double smallest_pivot() const;
  double factor_nonzeros() const;
  /// Whether A is, to the last bit, the matrix that was factored.
  bool is_factor_of(const BlockMatrix<double>& A) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Solves A x = b with the factor of A: a solve, and up to three steps of iterative refinement while the residual is
/// above ‖b - A x‖ ≤ relative_residual × ‖b‖ and still falls. Converged means that bound and nothing less; round-off
/// allows about ε ‖A‖ ‖x‖ / ‖b‖ (Higham 2002, section 12.2), which in slender or finely meshed bodies is much more than
/// ε. Iterations: the solves. Precondition: solver.factored().
SolveReport solve_refined(const DirectSolver& solver, const BlockMatrix<double>& A, const Eigen::VectorXd& b,
                          double relative_residual, Eigen::VectorXd& x);

/// Keeps the last factorization and hands it out again while the matrix is the same to the last bit, so it is never
/// stale: the coarsest matrix of a linear problem does not change while its mesh adapts.
class FactorCache {
 public:
  std::shared_ptr<const DirectSolver> factor(const BlockMatrix<double>& A);

 private:
  std::shared_ptr<const DirectSolver> solver_;
};

}  // namespace finegauge
