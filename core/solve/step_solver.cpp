#include "core/solve/step_solver.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>
#include <vector>

#include "core/parallel/for_parts.hpp"
#include "core/solve/direct_solver.hpp"

namespace finegauge {

namespace {

using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Three columns of A⁻¹ Bᵀ. The one place that solves with many right sides.
Columns solve_columns(const DirectSolver& factor, const Columns& right) { return factor.solve_columns(right); }

}  // namespace

struct StepSolver::State {
  StepSolverOptions options;
  const BlockMatrix<double>* A = nullptr;
  std::optional<DirectSolver> factor;
  bool factor_of_A = false;  ///< of the matrix given last, not of an older one
  int factorizations = 0, point_columns = 0;

  PointInterpolation B;
  std::vector<Columns> Y;  ///< per point of B, n × 3; empty: not computed yet

  // Of one solve.
  const PointTerm* term = nullptr;
  Eigen::LDLT<Eigen::MatrixXd> compliance, woodbury;  ///< C, C + Dᵀ B Y D
  ConjugateGradientVectors vectors;
  Eigen::VectorXd at_rows;
  std::vector<int> missing;  ///< points without their columns

  int rows() const { return term ? static_cast<int>(term->rows.size()) : 0; }

  /// at_rows = J x.
  void sample(const Eigen::VectorXd& x) {
    at_rows.resize(rows());
    for (int i = 0; i < rows(); ++i) {
      const PointRow& row = term->rows[i];
      at_rows[i] = row.direction.dot(sample_free(B, row.point, x));
    }
  }
  /// y = (A + Jᵀ C⁻¹ J) x.
  void apply(const Eigen::VectorXd& x, Eigen::VectorXd& y) {
    multiply(*A, x, y);
    if (rows() == 0) return;
    sample(x);
    compliance.solveInPlace(at_rows);
    for (int i = 0; i < rows(); ++i) add_spread(B, term->rows[i].point, at_rows[i] * term->rows[i].direction, y);
  }
  /// z = M⁻¹ r.
  void precondition(const Eigen::VectorXd& r, Eigen::VectorXd& z) {
    if (options.method == StepMethod::plain) {
      z = r;
      return;
    }
    z = factor->solve(r);
    if (rows() == 0) return;
    sample(z);
    woodbury.solveInPlace(at_rows);
    for (int i = 0; i < rows(); ++i) {
      const PointRow& row = term->rows[i];
      z.noalias() -= Y[row.point] * (at_rows[i] * row.direction);
    }
  }

  bool renew_factor() {
    // set_matrix drops the factor of another mesh, so the pattern is the same.
    if (!(factor && factor->factored() && factor->refactor(*A))) factor.emplace(*A);
    factor_of_A = true;
    ++factorizations;
    for (Columns& columns : Y) columns.resize(0, 3);
    return factor->factored();
  }
  /// Columns that the term's rows need and that are not there.
  void complete_columns() {
    missing.clear();
    for (const PointRow& row : term->rows)
      if (Y[row.point].rows() == 0 && std::ranges::find(missing, row.point) == missing.end())
        missing.push_back(row.point);
    for_parts(static_cast<int>(missing.size()), 1, [&](int first, int last) {
      Eigen::VectorXd spread;
      for (int i = first; i < last; ++i) {
        Columns right(3 * A->pattern->size(), 3);
        for (int k = 0; k < 3; ++k) {
          spread.setZero(right.rows());
          add_spread(B, missing[i], Eigen::Vector3d::Unit(k), spread);
          right.col(k) = spread;
        }
        Y[missing[i]] = solve_columns(*factor, right);
      }
    });
    point_columns += static_cast<int>(missing.size());
  }
  /// False where the preconditioner is not to be had: the matrix is not positive definite.
  bool prepare() {
    if (rows() > 0) compliance.compute(term->compliance);
    if (options.method == StepMethod::plain) return true;
    if (!factor && !renew_factor()) return false;
    if (!factor->factored()) return false;
    if (rows() == 0) return true;
    complete_columns();
    Eigen::MatrixXd total = term->compliance;
    Eigen::VectorXd& p = vectors.p;
    for (int j = 0; j < rows(); ++j) {
      const PointRow& column = term->rows[j];
      p.noalias() = Y[column.point] * column.direction;
      for (int i = j; i < rows(); ++i) {
        const PointRow& row = term->rows[i];
        total(i, j) += row.direction.dot(sample_free(B, row.point, p));
      }
    }
    woodbury.compute(total);  // reads the lower triangle
    return true;
  }
  /// A factor that has aged is renewed once the iterations show it.
  Renewal renew(int iterations) {
    if (options.method == StepMethod::plain || factor_of_A || iterations < options.renew_iterations)
      return Renewal::none;
    return renew_factor() && prepare() ? Renewal::renewed : Renewal::failed;
  }
  SolveReport iterate(const Eigen::VectorXd& b, double reference, Eigen::VectorXd& x) {
    const ConjugateGradientParts parts = {[this](const Eigen::VectorXd& y, Eigen::VectorXd& Ay) { apply(y, Ay); },
                                          [this](const Eigen::VectorXd& r, Eigen::VectorXd& z) { precondition(r, z); },
                                          [this](int iterations) { return renew(iterations); },
                                          {}};
    ConjugateGradientRules rules;
    rules.squared_residual =
        options.linear.relative_residual * options.linear.relative_residual * reference * reference;
    rules.iterations = options.linear.iterations;
    rules.least_iterations = rows() > 0 ? 1 : 0;
    rules.stagnation = 0.25;  // a half of the norm: a restart that gains less meets round-off
    return conjugate_gradients(parts, b, rules, vectors, x);
  }
};

StepSolver::StepSolver(const StepSolverOptions& options) : state_(std::make_unique<State>()) {
  state_->options = options;
}
StepSolver::~StepSolver() = default;
StepSolver::StepSolver(StepSolver&&) noexcept = default;
StepSolver& StepSolver::operator=(StepSolver&&) noexcept = default;

void StepSolver::set_matrix(const BlockMatrix<double>& A, bool same_mesh) {
  state_->A = &A;
  state_->factor_of_A = false;
  if (same_mesh && state_->factor && state_->factor->factored()) return;
  state_->factor.reset();
  for (Columns& columns : state_->Y) columns.resize(0, 3);
}

void StepSolver::set_points(const PointInterpolation& B) {
  std::vector<Columns> Y(B.point_count(), Columns(0, 3));
  const int before = state_->B.point_count();
  for (int q = 0; q < B.point_count(); ++q)
    for (int k = 0; k < before; ++k) {
      const int old = (q + k) % before;  // most often the same place in the list
      if (state_->Y[old].rows() == 0 || !same_point(B, q, state_->B, old)) continue;
      std::swap(Y[q], state_->Y[old]);
      break;
    }
  state_->B = B;
  state_->Y = std::move(Y);
}

SolveReport StepSolver::solve(const PointTerm* term, const Eigen::VectorXd& b, double reference, Eigen::VectorXd& x) {
  State& state = *state_;
  assert(state.A && b.size() == 3 * state.A->pattern->size() && x.size() == b.size());
  if (b.squaredNorm() == 0.0) {
    x.setZero();
    return {true, 0, 0.0};
  }
  state.term = term;
  SolveReport report;
  if (state.prepare()) {
    report = state.iterate(b, reference, x);
  } else {
    state.apply(x, state.vectors.Ap);
    state.vectors.r = b - state.vectors.Ap;
  }
  report.relative_residual = state.vectors.r.norm() / reference;
  state.term = nullptr;
  return report;
}

SolveReport StepSolver::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) { return solve(nullptr, b, b.norm(), x); }

int StepSolver::factorizations() const { return state_->factorizations; }
int StepSolver::point_columns() const { return state_->point_columns; }
const StepSolverOptions& StepSolver::options() const { return state_->options; }

}  // namespace finegauge
