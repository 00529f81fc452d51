#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/solve/conjugate_gradients.hpp"
#include "core/solve/point_interpolation.hpp"
#include "core/solve/solve_report.hpp"
#include "core/space/block_matrix.hpp"

namespace finegauge {

enum class StepMethod {
  plain,  ///< conjugate gradients without preconditioner (the paper's)
  kept    ///< conjugate gradients preconditioned by a Cholesky factor that is kept from frame to frame and renewed when
          ///< the iterations show that it has aged, or the mesh is another
};
struct StepSolverOptions {
  StepMethod method = StepMethod::kept;
  IterationLimits linear{1e-9, 2000};
  int renew_iterations = 8;  ///< kept: a solve that has done this many with an older matrix's factor gets a new one
};

/// One scalar row J_i = direction · B_point; its sign plays no part.
struct PointRow {
  int point = 0;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, global axes
};
/// Jᵀ C⁻¹ J, m rows at points that give way with compliance C: what augmented constraint rows add to the tissue once
/// the needle is eliminated (C = W⁻¹ + the needle's compliance at the rows). Given by C and not by its inverse, since
/// Woodbury's formula needs C + J A⁻¹ Jᵀ, which stays well conditioned where C is small.
struct PointTerm {
  std::vector<PointRow> rows;
  Eigen::MatrixXd compliance;  ///< C, m × m, symmetric positive definite
};

/// Solves the linear systems of successive frames, whose matrices change little. Invariant: what it keeps (factor
/// A_F, columns Y = A_F⁻¹ Bᵀ of the points) only preconditions; every solution is of the matrix given last, to the
/// residual reported. With an exact factor the preconditioner is the inverse:
///   (A_F + Jᵀ C⁻¹ J)⁻¹ = A_F⁻¹ - Y D (C + Dᵀ B Y D)⁻¹ Dᵀ B A_F⁻¹   (Woodbury 1950), J = Dᵀ B, D the directions.
class StepSolver {
 public:
  explicit StepSolver(const StepSolverOptions& options = {});
  ~StepSolver();
  StepSolver(StepSolver&&) noexcept;
  StepSolver& operator=(StepSolver&&) noexcept;

  /// The matrix of this frame, supports applied, borrowed until the next call; `same_mesh`: pattern and supports are
  /// those of the last one.
  void set_matrix(const BlockMatrix<double>& A, bool same_mesh);
  /// The points that terms refer to, copied. Y is kept of those that are the same to the last bit as one of before.
  void set_points(const PointInterpolation& B);
  /// x <- (A + Jᵀ C⁻¹ J)⁻¹ b from the x given; b and x without held directions. No term: nullptr. Converged: the
  /// residual is at most linear.relative_residual × `reference` (a norm [N s], > 0; what b is made of may be far
  /// smaller than b); reported relative to it. With a term at least one iteration is done, however good the start: an
  /// outer iteration that goes on needs its progress. A matrix that is not positive definite gives converged = false
  /// and a finite x.
  SolveReport solve(const PointTerm* term, const Eigen::VectorXd& b, double reference, Eigen::VectorXd& x);
  /// Without a term, relative to ‖b‖.
  SolveReport solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

  int factorizations() const;  ///< so far
  int point_columns() const;   ///< points whose columns Y were computed, so far
  const StepSolverOptions& options() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace finegauge
