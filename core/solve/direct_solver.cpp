#include "core/solve/direct_solver.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <vector>

namespace finegauge {

namespace {

/// pivot_j / A_jj up to which a pivot may be nothing but round-off. Cholesky's backward error is at most (n + 1) ε A_jj
/// on the diagonal (Higham 2002, theorem 10.3), whatever the scales of the rows; what is left for the last pivot of a
/// body that is not held is that error summed over its motion. Free boxes of cubes and of tetrahedra, up to 2e4 dofs,
/// gave up to 2.1 n ε. The upper end, twice what they reached at that size, is for held bodies whose pivots are that
/// small: cells of aspect 1:1000 at nu = 0.49999 have 3e-11 in one row and 1e-12 to 3e-12 in plates; large plates of
/// such cells are refused. Supports that hold too little are found before, exactly (supports.hpp, free_rigid_motions).
double round_off_pivot(int n) { return std::min(4.0 * n * std::numeric_limits<double>::epsilon(), 1.5e-11); }

/// Calls visit(row, value) for the entries of A's upper triangle by columns, rows ascending: column j of blocks is row
/// j of the symmetric matrix, each block transposed. After each column calls end_column().
template <class Visit, class EndColumn>
void visit_upper_triangle(const BlockMatrix<double>& A, const Visit& visit, const EndColumn& end_column) {
  const BlockPattern& pattern = *A.pattern;
  for (int j = 0; j < pattern.size(); ++j)
    for (int c = 0; c < 3; ++c) {
      for (int p = pattern.row_start[j]; p <= pattern.diagonal[j]; ++p) {
        const auto block = A.block(p);
        const int rows = p == pattern.diagonal[j] ? c + 1 : 3;
        for (int r = 0; r < rows; ++r) visit(3 * pattern.column[p] + r, block(c, r));
      }
      end_column();
    }
}

/// e such that 2^-e A has its largest diagonal entry in [1, 2); 0 where 2^-e or 2^e would leave the range of a double.
int scale_exponent(const BlockMatrix<double>& A) {
  double largest = 0.0;
  for (const int p : A.pattern->diagonal) largest = std::max(largest, A.block(p).diagonal().maxCoeff());
  if (!(largest > 0.0 && std::isfinite(largest))) return 0;
  const int exponent = std::ilogb(largest);
  return std::abs(exponent) <= 1000 ? exponent : 0;
}

/// The diagonal of a factor L, in the order of its pivots.
template <class Visit>
void visit_pivots(const cholmod_factor& L, const Visit& visit) {
  const auto* const x = static_cast<const double*>(L.x);
  if (!L.is_super) {
    const auto* const start = static_cast<const int*>(L.p);
    for (std::size_t j = 0; j < L.n; ++j) visit(j, x[start[j]]);
    return;
  }
  const auto *const first_column = static_cast<const int*>(L.super), *const first_row = static_cast<const int*>(L.pi),
                    *const values = static_cast<const int*>(L.px);
  for (std::size_t s = 0; s < L.nsuper; ++s) {
    const std::size_t rows = static_cast<std::size_t>(first_row[s + 1] - first_row[s]);
    for (int j = first_column[s]; j < first_column[s + 1]; ++j) {
      const std::size_t place = static_cast<std::size_t>(j - first_column[s]);
      visit(static_cast<std::size_t>(j), x[static_cast<std::size_t>(values[s]) + place * (rows + 1)]);
    }
  }
}

void start_quietly(cholmod_common& common) {
  cholmod_start(&common);
  common.print = 0;
}

}  // namespace

struct DirectSolver::State {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  bool factored = false;
  double smallest_pivot = 0.0;
  // The matrix that was factored, 2^-exponent A, in CHOLMOD's format. Kept: the memory's peak is while factoring, when
  // it has to exist anyway, and with it refactoring allocates nothing and a factor knows whose it is.
  int exponent = 0;
  std::vector<int> start, row;
  std::vector<double> value;

  State() {
    start_quietly(common);
    common.final_ll = 1;  // L Lᵀ fails at a pivot that is not positive, L D Lᵀ would go on
  }
  ~State() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  cholmod_sparse matrix() {
    cholmod_sparse view{};
    view.nrow = view.ncol = start.size() - 1;
    view.nzmax = row.size();
    view.p = start.data();
    view.i = row.data();
    view.x = value.data();
    view.stype = 1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    return view;
  }

  bool has_pattern_of(const BlockMatrix<double>& A) const {
    if (start.size() != 3 * static_cast<std::size_t>(A.pattern->size()) + 1) return false;
    std::size_t k = 0, column = 0;
    bool same = true;
    visit_upper_triangle(
        A, [&](int r, double) { same = same && k < row.size() && row[k] == r, ++k; },
        [&] { same = same && start[++column] == static_cast<int>(k); });
    return same;
  }

  void factorize() {
    factored = false;
    smallest_pivot = 0.0;
    cholmod_sparse scaled = matrix();
    if (!factor || !cholmod_factorize(&scaled, factor, &common)) return;
    if (common.status != CHOLMOD_OK || factor->minor != factor->n) return;
    smallest_pivot = 1.0;
    const auto* const order = static_cast<const int*>(factor->Perm);
    visit_pivots(*factor, [&](std::size_t j, double pivot) {
      // The last entry of a column of the upper triangle is the diagonal's. Written so that NaN fails.
      const double ratio = pivot * pivot / value[static_cast<std::size_t>(start[order[j] + 1] - 1)];
      if (!(ratio >= smallest_pivot)) smallest_pivot = ratio;
    });
    factored = smallest_pivot > round_off_pivot(static_cast<int>(factor->n));
  }

  /// `own`: CHOLMOD's workspace, one for each thread that solves at the same time.
  void solve(const double* B, std::size_t columns, double* X, cholmod_common& own) const {
    assert(factored);
    if (columns == 0) return;
    cholmod_dense right{};
    right.nrow = right.d = factor->n;
    right.ncol = columns;
    right.nzmax = factor->n * columns;
    right.x = const_cast<double*>(B);
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor, &right, &own);
    if (!solution) throw std::bad_alloc();
    // A = 2^e (2^-e A).
    const double scale = std::ldexp(1.0, -exponent);
    std::transform(static_cast<const double*>(solution->x), static_cast<const double*>(solution->x) + right.nzmax, X,
                   [scale](double x) { return scale * x; });
    cholmod_free_dense(&solution, &own);
  }
};

DirectSolver::DirectSolver(const BlockMatrix<double>& A) : state_(std::make_unique<State>()) {
  State& s = *state_;
  const int n = 3 * A.pattern->size();
  s.exponent = scale_exponent(A);
  s.start.reserve(static_cast<std::size_t>(n) + 1);
  // Nine entries of each block below the diagonal, six of each on it.
  const auto blocks = static_cast<std::size_t>(A.pattern->block_count());
  s.row.reserve(9 * (blocks - static_cast<std::size_t>(n) / 3) / 2 + 2 * static_cast<std::size_t>(n));
  s.value.reserve(s.row.capacity());
  s.start.push_back(0);
  const double scale = std::ldexp(1.0, -s.exponent);
  visit_upper_triangle(
      A, [&](int r, double a) { s.row.push_back(r), s.value.push_back(scale * a); },
      [&] { s.start.push_back(static_cast<int>(s.row.size())); });
  // Small factors have no supernodes worth a call of BLAS, whose first one costs more than the whole factor.
  constexpr int small = 2000;
  if (n < small) s.common.supernodal = CHOLMOD_SIMPLICIAL;
  cholmod_sparse scaled = s.matrix();
  s.factor = cholmod_analyze(&scaled, &s.common);
  s.factorize();
}

DirectSolver::~DirectSolver() = default;
DirectSolver::DirectSolver(DirectSolver&&) noexcept = default;
DirectSolver& DirectSolver::operator=(DirectSolver&&) noexcept = default;

bool DirectSolver::refactor(const BlockMatrix<double>& A) {
  State& s = *state_;
  assert(s.has_pattern_of(A));
  s.exponent = scale_exponent(A);
  const double scale = std::ldexp(1.0, -s.exponent);
  std::size_t k = 0;
  visit_upper_triangle(
      A, [&](int, double a) { s.value[k++] = scale * a; }, [] {});
  s.factorize();
  return s.factored;
}

bool DirectSolver::factored() const { return state_->factored; }
double DirectSolver::smallest_pivot() const { return state_->smallest_pivot; }
double DirectSolver::factor_nonzeros() const { return state_->common.lnz; }

bool DirectSolver::is_factor_of(const BlockMatrix<double>& A) const {
  const State& s = *state_;
  if (s.exponent != scale_exponent(A) || !s.has_pattern_of(A)) return false;
  const double scale = std::ldexp(1.0, -s.exponent);
  std::size_t k = 0;
  bool same = true;
  visit_upper_triangle(
      A, [&](int, double a) { same = same && s.value[k++] == scale * a; }, [] {});
  return same;
}

Eigen::MatrixXd DirectSolver::solve_columns(const Eigen::MatrixXd& B) const {
  Eigen::MatrixXd X(B.rows(), B.cols());
  cholmod_common own;
  start_quietly(own);
  const std::unique_ptr<cholmod_common, void (*)(cholmod_common*)> end(&own,
                                                                       [](cholmod_common* c) { cholmod_finish(c); });
  state_->solve(B.data(), static_cast<std::size_t>(B.cols()), X.data(), own);
  return X;
}

Eigen::VectorXd DirectSolver::solve(const Eigen::VectorXd& b) const {
  Eigen::VectorXd x(b.size());
  state_->solve(b.data(), 1, x.data(), state_->common);
  return x;
}

SolveReport solve_refined(const DirectSolver& solver, const BlockMatrix<double>& A, const Eigen::VectorXd& b,
                          double relative_residual, Eigen::VectorXd& x) {
  SolveReport report;
  constexpr int most_solves = 4;
  const double norm = b.norm();
  x.setZero(b.size());
  if (norm == 0.0) {
    report.converged = true;
    return report;
  }
  Eigen::VectorXd r = b, candidate, Ax;
  report.relative_residual = 1.0;
  while (report.iterations < most_solves) {
    candidate = x + solver.solve(r);
    ++report.iterations;
    multiply(A, candidate, Ax);
    r = b - Ax;
    const double found = r.norm() / norm;
    if (!(found < report.relative_residual)) break;  // round-off's floor, or not a number: x is the best there is
    x.swap(candidate);
    report.relative_residual = found;
    if (found <= relative_residual) break;
  }
  report.converged = report.relative_residual <= relative_residual;
  return report;
}

std::shared_ptr<const DirectSolver> FactorCache::factor(const BlockMatrix<double>& A) {
  if (solver_ && solver_->is_factor_of(A)) return solver_;
  solver_.reset();  // before the new one is made: two factors need not fit the memory
  solver_ = std::make_shared<const DirectSolver>(A);
  return solver_;
}

}  // namespace finegauge
