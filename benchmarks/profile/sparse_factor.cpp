#include "benchmarks/profile/sparse_factor.hpp"

#include <cholmod.h>

#include <new>
#include <vector>

namespace finegauge {

struct SparseFactor::State {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  std::vector<int> start, row;  // lower triangle by columns
  std::vector<double> value;

  State() { cholmod_start(&common); }
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
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = view.packed = 1;
    return view;
  }
  void copy_values(const Eigen::SparseMatrix<double>& A) {
    std::size_t k = 0;
    for (Eigen::Index j = 0; j < A.outerSize(); ++j)
      for (Eigen::SparseMatrix<double>::InnerIterator entry(A, j); entry; ++entry)
        if (entry.row() >= j) value[k++] = entry.value();
  }
};

SparseFactor::SparseFactor(const Eigen::SparseMatrix<double>& A, Kind kind) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.common.print = 0;
  s.common.final_ll = kind == Kind::positive_definite;
  if (kind == Kind::quasidefinite) s.common.supernodal = CHOLMOD_SIMPLICIAL;  // dense blocks have no L D Lᵀ
  s.start.push_back(0);
  for (Eigen::Index j = 0; j < A.outerSize(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(A, j); entry; ++entry)
      if (entry.row() >= j) s.row.push_back(static_cast<int>(entry.row()));
    s.start.push_back(static_cast<int>(s.row.size()));
  }
  s.value.resize(s.row.size());
  s.copy_values(A);
}
SparseFactor::~SparseFactor() = default;
SparseFactor::SparseFactor(SparseFactor&&) noexcept = default;

void SparseFactor::analyze() {
  State& s = *state_;
  cholmod_free_factor(&s.factor, &s.common);
  cholmod_sparse matrix = s.matrix();
  s.factor = cholmod_analyze(&matrix, &s.common);
  if (!s.factor) throw std::bad_alloc();
}

bool SparseFactor::factorize() {
  State& s = *state_;
  cholmod_sparse matrix = s.matrix();
  return cholmod_factorize(&matrix, s.factor, &s.common) && s.common.status == CHOLMOD_OK &&
         s.factor->minor == s.factor->n;
}

bool SparseFactor::factorize(const Eigen::SparseMatrix<double>& A) {
  state_->copy_values(A);
  return factorize();
}

Eigen::VectorXd SparseFactor::solve(const Eigen::VectorXd& b) const {
  State& s = *state_;
  cholmod_dense right{};
  right.nrow = right.d = right.nzmax = s.factor->n;
  right.ncol = 1;
  right.x = const_cast<double*>(b.data());
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* solution = cholmod_solve(CHOLMOD_A, s.factor, &right, &s.common);
  if (!solution) throw std::bad_alloc();
  const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(static_cast<const double*>(solution->x), b.size());
  cholmod_free_dense(&solution, &s.common);
  return x;
}

double SparseFactor::factor_nonzeros() const { return state_->common.lnz; }
double SparseFactor::factor_flops() const { return state_->common.fl; }

}  // namespace finegauge
