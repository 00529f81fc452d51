#include "core/solve/direct_solver.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <new>
#include <vector>

namespace finegauge {

namespace {

/// Ratio of smallest to largest pivot up to which the smallest may be nothing but round-off. Cholesky's backward error
/// grows with the size n of the matrix (Higham 2002, theorem 10.3); stiffnesses of bodies that are not held were seen
/// with ratios of up to 0.4 n ε, and up to 3e-13. The upper end is there because the bound is pessimistic for large n:
/// held cells of aspect 1:1000 at nu = 0.4999 have 7e-12.
double round_off_pivot(int n) { return std::min(n * std::numeric_limits<double>::epsilon(), 1e-12); }

}  // namespace

struct DirectSolver::State {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  bool factored = false;

  State() {
    cholmod_start(&common);
    common.print = 0;
    common.final_ll = 1;  // L Lᵀ fails at a pivot that is not positive, L D Lᵀ would go on
  }
  ~State() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

DirectSolver::DirectSolver(const BlockMatrix<double>& A) : state_(std::make_unique<State>()) {
  // The upper triangle by columns: column j of blocks is row j of the symmetric matrix, each block transposed.
  const BlockPattern& pattern = *A.pattern;
  const int n = 3 * pattern.size();
  std::vector<int> start(n + 1, 0), row;
  std::vector<double> value;
  row.reserve(5 * static_cast<std::size_t>(pattern.block_count()));
  value.reserve(row.capacity());
  for (int j = 0; j < pattern.size(); ++j)
    for (int c = 0; c < 3; ++c) {
      for (int p = pattern.row_start[j]; p <= pattern.diagonal[j]; ++p) {
        const auto block = A.block(p);
        const int rows = p == pattern.diagonal[j] ? c + 1 : 3;
        for (int r = 0; r < rows; ++r) {
          row.push_back(3 * pattern.column[p] + r);
          value.push_back(block(c, r));
        }
      }
      start[3 * j + c + 1] = static_cast<int>(row.size());
    }
  cholmod_sparse matrix{};
  matrix.nrow = matrix.ncol = static_cast<std::size_t>(n);
  matrix.nzmax = row.size();
  matrix.p = start.data();
  matrix.i = row.data();
  matrix.x = value.data();
  matrix.stype = 1;
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = CHOLMOD_REAL;
  matrix.dtype = CHOLMOD_DOUBLE;
  matrix.sorted = 1;
  matrix.packed = 1;
  cholmod_common* const common = &state_->common;
  // Small factors have no supernodes worth a call of BLAS, whose first one costs more than the whole factor.
  constexpr int small = 2000;
  if (n < small) common->supernodal = CHOLMOD_SIMPLICIAL;
  state_->factor = cholmod_analyze(&matrix, common);
  if (state_->factor && cholmod_factorize(&matrix, state_->factor, common))
    state_->factored = common->status == CHOLMOD_OK && state_->factor->minor == state_->factor->n &&
                       cholmod_rcond(state_->factor, common) > round_off_pivot(n);
}

DirectSolver::~DirectSolver() = default;
DirectSolver::DirectSolver(DirectSolver&&) noexcept = default;
DirectSolver& DirectSolver::operator=(DirectSolver&&) noexcept = default;

bool DirectSolver::factored() const { return state_->factored; }

Eigen::VectorXd DirectSolver::solve(const Eigen::VectorXd& b) const {
  assert(factored());
  cholmod_dense right{};
  right.nrow = right.nzmax = right.d = static_cast<std::size_t>(b.size());
  right.ncol = 1;
  right.x = const_cast<double*>(b.data());
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* solution = cholmod_solve(CHOLMOD_A, state_->factor, &right, &state_->common);
  if (!solution) throw std::bad_alloc();
  Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(static_cast<const double*>(solution->x), b.size());
  cholmod_free_dense(&solution, &state_->common);
  return x;
}

double DirectSolver::factor_nonzeros() const { return state_->common.lnz; }

std::shared_ptr<const DirectSolver> FactorCache::factor(const BlockMatrix<double>& A) {
  const BlockPattern& pattern = *A.pattern;
  if (!solver_ || values_ != A.values || column_ != pattern.column || row_start_ != pattern.row_start) {
    solver_ = std::make_shared<const DirectSolver>(A);
    values_ = A.values;
    column_ = pattern.column;
    row_start_ = pattern.row_start;
  }
  return solver_;
}

}  // namespace finegauge
