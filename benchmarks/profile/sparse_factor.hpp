#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

namespace finegauge {

/// CHOLMOD on a symmetric scalar matrix with its steps apart, to time and count them: a Cholesky factor in the order
/// and with the counts of core/solve/direct_solver.hpp, or L D Lᵀ of a quasidefinite matrix, which the core never
/// meets. Factors exist in any order of elimination for quasidefinite matrices (Vanderbei 1995). Whether a Cholesky
/// factor is made by dense blocks is left to CHOLMOD, so that matrices of different sizes compare; the core decides by
/// the size.
class SparseFactor {
 public:
  enum class Kind { positive_definite, quasidefinite };
  /// A: both triangles; the lower one is read. Columns sorted.
  SparseFactor(const Eigen::SparseMatrix<double>& A, Kind kind);
  ~SparseFactor();
  SparseFactor(SparseFactor&&) noexcept;

  void analyze();  ///< order and pattern of the factor
  /// The matrix as it was given, or another on its pattern. False where a pivot is zero or, of a positive definite
  /// matrix, not positive.
  [[nodiscard]] bool factorize();
  [[nodiscard]] bool factorize(const Eigen::SparseMatrix<double>& A);
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

  double factor_nonzeros() const;  ///< of L, after analyze
  double factor_flops() const;     ///< multiplications and additions of a Cholesky factorization, after analyze

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace finegauge
