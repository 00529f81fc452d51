#include "benchmarks/profile/tjunction_handling.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <algorithm>
#include <cstddef>
#include <optional>
#include <unsupported/Eigen/IterativeSolvers>
#include <utility>

#include "benchmarks/profile/processor_clock.hpp"
#include "benchmarks/profile/sparse_factor.hpp"
#include "benchmarks/profile/unreduced.hpp"
#include "core/solve/conjugate_gradients.hpp"
#include "core/space/assembly.hpp"

namespace finegauge {
namespace {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Processor times of one step of one handling over the repetitions.
using Times = std::vector<double>;
template <class Work>
double time_of(const Work& work) {
  Stopwatch watch(processor_clock());
  work();
  return watch.lap();
}

/// What all handlings share: the mesh with T and without.
struct Meshes {
  const Discretization& d;
  Discretization free;          // every node for itself
  Discretization hanging_only;  // the same with the cells alone that have hanging corners
  const Eigen::Matrix3Xd& at;
  const Eigen::Matrix3Xd& loads;

  Meshes(const Discretization& given, const Eigen::Matrix3Xd& displacement, const Eigen::Matrix3Xd& forces)
      : d(given), free(unreduced(given)), hanging_only(free), at(displacement), loads(forces) {
    hanging_only.scatter.regular = d.scatter.hanging;
  }
};

void assemble_nodal(const Meshes& meshes, BlockMatrix<double>& A) {
  A.reset(meshes.free.pattern);
  assemble_regular_cells(meshes.free, meshes.at, A);
}

/// A block matrix as rows of scalars whose pattern is made once and whose values are copied.
class ScalarRows {
 public:
  explicit ScalarRows(const BlockMatrix<double>& A) : matrix_(to_sparse(A)) {}
  const RowMatrix& copy_of(const BlockMatrix<double>& A) {
    const BlockPattern& pattern = *A.pattern;
    double* value = matrix_.valuePtr();
    for (int i = 0; i < pattern.size(); ++i)
      for (int r = 0; r < 3; ++r)
        for (int p = pattern.row_start[i]; p < pattern.row_start[i + 1]; ++p) {
          const double* block = A.values.data() + 9 * static_cast<std::size_t>(p);
          for (int c = 0; c < 3; ++c) *value++ = block[3 * c + r];
        }
    return matrix_;
  }

 private:
  RowMatrix matrix_;
};

struct Measured {
  HandlingCost cost;
  Times assemble, reduce, symbolic, numeric, solve;

  explicit Measured(TjunctionHandling handling) { cost.handling = handling; }
  void factor(SparseFactor& factor) {
    symbolic.push_back(time_of([&] { factor.analyze(); }));
    numeric.push_back(time_of([&] { cost.solved = factor.factorize() && cost.solved; }));
    cost.factor_nonzeros = factor.factor_nonzeros();
    cost.factor_flops = factor.factor_flops();
  }
  HandlingCost finished() {
    cost.assemble_ms = median_ms(assemble), cost.reduce_ms = median_ms(reduce), cost.symbolic_ms = median_ms(symbolic);
    cost.numeric_ms = median_ms(numeric), cost.solve_ms = median_ms(solve);
    return std::move(cost);
  }
};

/// Conjugate gradients from zero without a preconditioner.
void count_iterations(const BlockMatrix<double>& A, const Eigen::VectorXd& b, const HandlingOptions& options,
                      HandlingCost& cost) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
  const SolveReport report = conjugate_gradients(
      A, b, [](const Eigen::VectorXd& r, Eigen::VectorXd& z) { z = r; }, {options.residual, options.most_iterations},
      x);
  cost.iterations = report.iterations;
  cost.solved = cost.solved && report.converged;
}

/// The load of the free directions of a discretization.
Eigen::VectorXd load_vector(const Discretization& d, const Eigen::Matrix3Xd& loads) {
  Eigen::VectorXd b = reduce_forces(d.hanging, loads);
  project(d.supports, b);
  return b;
}

/// Elementwise reduction, and the matrix of all nodes as it is when `d` is the mesh without T.
class BlockSystem {
 public:
  BlockSystem(const Meshes& meshes, TjunctionHandling handling)
      : meshes_(meshes), d_(handling == TjunctionHandling::ignored ? meshes.free : meshes.d), measured_(handling) {
    b_ = load_vector(d_, meshes.loads);
    measured_.cost.unknowns = static_cast<int>(b_.size());
    measured_.cost.matrix_nonzeros = 9.0 * d_.pattern.block_count();
  }
  void repeat() {
    measured_.assemble.push_back(time_of([&] {
      A_.reset(d_.pattern);
      assemble_regular_cells(d_, meshes_.at, A_);
    }));
    const double hanging = time_of([&] { assemble_hanging_cells(d_, meshes_.at, A_); });
    double without_T = 0.0;
    if (!d_.scatter.hanging.empty()) {
      scratch_.reset(meshes_.hanging_only.pattern);
      without_T = time_of([&] { assemble_regular_cells(meshes_.hanging_only, meshes_.at, scratch_); });
    }
    measured_.assemble.back() += without_T + time_of([&] { apply_supports(d_.supports, A_); });
    measured_.reduce.push_back(std::max(0.0, hanging - without_T));
    SparseFactor factor(to_sparse(A_), SparseFactor::Kind::positive_definite);
    measured_.factor(factor);
    if (!measured_.cost.solved) return;
    measured_.solve.push_back(
        time_of([&] { measured_.cost.u = expand(d_.hanging, factor.solve(load_vector(d_, meshes_.loads))); }));
  }
  void iterate(const HandlingOptions& options) { count_iterations(A_, b_, options, measured_.cost); }
  HandlingCost finished() { return measured_.finished(); }

 private:
  const Meshes& meshes_;
  const Discretization& d_;
  Measured measured_;
  Eigen::VectorXd b_;
  BlockMatrix<double> A_, scratch_;
};

/// Tᵀ A T by Eigen's sparse products; supports on the product, as it has the masters' rows only then.
class ProductSystem {
 public:
  explicit ProductSystem(const Meshes& meshes)
      : meshes_(meshes),
        measured_(TjunctionHandling::explicit_product),
        T_(interpolation_matrix(meshes.d.hanging)),
        Tt_(T_.transpose()) {
    assemble_nodal(meshes_, A_);
    rows_.emplace(A_);
    blocks_.reset(meshes.d.pattern);
    measured_.cost.unknowns = meshes.d.dof_count();
  }
  void repeat() {
    measured_.assemble.push_back(time_of([&] { assemble_nodal(meshes_, A_); }));
    measured_.reduce.push_back(time_of([&] {
      const RowMatrix& A = rows_->copy_of(A_);
      const RowMatrix AT = A * T_;
      product_ = Tt_ * AT;
    }));
    measured_.cost.matrix_nonzeros = static_cast<double>(product_.nonZeros());
    into_blocks();
    measured_.assemble.back() += time_of([&] { apply_supports(meshes_.d.supports, blocks_); });
    SparseFactor factor(to_sparse(blocks_), SparseFactor::Kind::positive_definite);
    measured_.factor(factor);
    if (!measured_.cost.solved) return;
    measured_.solve.push_back(time_of(
        [&] { measured_.cost.u = expand(meshes_.d.hanging, factor.solve(load_vector(meshes_.d, meshes_.loads))); }));
  }
  void iterate(const HandlingOptions& options) {
    count_iterations(blocks_, load_vector(meshes_.d, meshes_.loads), options, measured_.cost);
  }
  HandlingCost finished() { return measured_.finished(); }

 private:
  /// Not timed: a program that works with the product would hold its supports otherwise.
  void into_blocks() {
    blocks_.reset(meshes_.d.pattern);
    const BlockPattern& pattern = meshes_.d.pattern;
    for (int i = 0; i < pattern.size(); ++i)
      for (int r = 0; r < 3; ++r)
        for (RowMatrix::InnerIterator entry(product_, 3 * i + r); entry; ++entry) {
          const auto row = pattern.column.begin() + pattern.row_start[i];
          const auto end = pattern.column.begin() + pattern.row_start[i + 1];
          const int column = static_cast<int>(entry.col());
          const auto found = std::lower_bound(row, end, column / 3);
          // What is not in the pattern is no coupling of any cell: it must be zero.
          if (found == end || *found != column / 3)
            measured_.cost.solved = measured_.cost.solved && entry.value() == 0.0;
          else
            blocks_.block(static_cast<int>(found - pattern.column.begin()))(r, column % 3) = entry.value();
        }
  }

  const Meshes& meshes_;
  Measured measured_;
  RowMatrix T_, Tt_, product_;
  BlockMatrix<double> A_, blocks_;
  std::optional<ScalarRows> rows_;
};

/// | A  β Gᵀ | with G u = 0: each component of a hanging node is that of its masters. β, the mean of A's diagonal,
/// | β G   0 | brings both parts to one scale. The factor is of the matrix with -1e-8 β in place of zero, which has one
///             in any order; what that changes is taken out by refining the solution with the matrix itself.
class MultiplierSystem {
 public:
  explicit MultiplierSystem(const Meshes& meshes) : meshes_(meshes), measured_(TjunctionHandling::multiplier) {
    assemble_nodal(meshes_, A_);
    apply_supports(meshes_.free.supports, A_);
    nodal_ = static_cast<int>(3 * meshes_.d.mesh.node_count());
    size_ = nodal_ + 3 * meshes_.d.hanging.hanging_count();
    double beta = 0.0;
    for (const int p : meshes_.free.pattern.diagonal) beta += A_.block(p).trace() / nodal_;
    build(beta);
    right_ = Eigen::VectorXd::Zero(size_);
    right_.head(nodal_) = load_vector(meshes_.free, meshes_.loads);
    measured_.cost.unknowns = size_;
    measured_.cost.matrix_nonzeros = static_cast<double>(matrix_.nonZeros());
  }
  void repeat() {
    measured_.assemble.push_back(time_of([&] {
      assemble_nodal(meshes_, A_);
      apply_supports(meshes_.free.supports, A_);
    }));
    measured_.reduce.push_back(time_of([&] {
      double* value = matrix_.valuePtr();
      for (std::size_t k = 0; k < source_.size(); ++k)
        if (source_[k] >= 0) value[k] = A_.values[static_cast<std::size_t>(source_[k])];
    }));
    Eigen::SparseMatrix<double> shifted = matrix_ + shift_;
    SparseFactor factor(shifted, SparseFactor::Kind::quasidefinite);
    measured_.factor(factor);
    if (!measured_.cost.solved) return;
    measured_.solve.push_back(time_of([&] { refine(factor); }));
  }
  void iterate(const HandlingOptions& options) {
    Eigen::MINRES<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper, Eigen::IdentityPreconditioner> minres(
        matrix_);
    minres.setTolerance(options.residual);
    minres.setMaxIterations(options.most_iterations);
    const Eigen::VectorXd x = minres.solve(right_);
    measured_.cost.iterations = static_cast<int>(minres.iterations());
    measured_.cost.solved = measured_.cost.solved && minres.info() == Eigen::Success && x.allFinite();
  }
  HandlingCost finished() { return measured_.finished(); }

 private:
  void build(double beta) {
    // First with the place of each value in the block matrix as the entry, to learn where the values go.
    std::vector<Eigen::Triplet<double>> places;
    const BlockPattern& pattern = meshes_.free.pattern;
    for (int i = 0; i < pattern.size(); ++i)
      for (int p = pattern.row_start[i]; p < pattern.row_start[i + 1]; ++p)
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) places.emplace_back(3 * i + r, 3 * pattern.column[p] + c, 9.0 * p + 3 * c + r);
    std::vector<Eigen::Triplet<double>> constraints, shift;
    add_constraints(beta, constraints);
    for (const auto& entry : constraints) places.emplace_back(entry.row(), entry.col(), -1.0);
    matrix_.resize(size_, size_);
    matrix_.setFromTriplets(places.begin(), places.end());
    source_.assign(matrix_.valuePtr(), matrix_.valuePtr() + matrix_.nonZeros());
    for (const auto& entry : constraints) matrix_.coeffRef(entry.row(), entry.col()) = entry.value();
    for (int k = nodal_; k < size_; ++k) shift.emplace_back(k, k, -1e-8 * beta);
    shift_.resize(size_, size_);
    shift_.setFromTriplets(shift.begin(), shift.end());
  }
  void add_constraints(double beta, std::vector<Eigen::Triplet<double>>& entries) const {
    const HangingNodes& hanging = meshes_.d.hanging;
    const Supports& supports = meshes_.d.supports;
    int row = nodal_;
    for (int node = 0; node < hanging.node_count(); ++node) {
      if (!hanging.hangs(node)) continue;
      const auto add = [&](int other, const Eigen::Matrix3d& weight) {
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) {
            if (weight(r, c) == 0.0) continue;
            entries.emplace_back(row + r, 3 * other + c, beta * weight(r, c));
            entries.emplace_back(3 * other + c, row + r, beta * weight(r, c));
          }
      };
      add(node, Eigen::Matrix3d::Identity());
      for (int k = hanging.row_start[node]; k < hanging.row_start[node + 1]; ++k) {
        // Held directions of a master are zero and stay out of the constraint.
        Eigen::Matrix3d Z = Eigen::Matrix3d::Identity();
        const auto held = std::lower_bound(supports.reduced.begin(), supports.reduced.end(), hanging.master[k]);
        if (held != supports.reduced.end() && *held == hanging.master[k])
          Z -= supports.held[static_cast<std::size_t>(held - supports.reduced.begin())];
        add(hanging.node_of[hanging.master[k]], -hanging.weight[k] * Z);
      }
      row += 3;
    }
  }
  void refine(const SparseFactor& factor) {
    constexpr int most = 30;
    Eigen::VectorXd x = factor.solve(right_);
    Eigen::VectorXd r = right_ - matrix_ * x;
    int& steps = measured_.cost.refinements;
    double last = r.norm();
    for (steps = 0; steps < most && last > 1e-13 * right_.norm(); ++steps) {
      const Eigen::VectorXd better = x + factor.solve(r);
      r = right_ - matrix_ * better;
      if (!(r.norm() < last)) break;
      last = r.norm();
      x = better;
    }
    measured_.cost.u = Eigen::Map<const Eigen::Matrix3Xd>(x.data(), 3, nodal_ / 3);
  }

  const Meshes& meshes_;
  Measured measured_;
  int nodal_ = 0, size_ = 0;
  BlockMatrix<double> A_;
  Eigen::SparseMatrix<double> matrix_, shift_;
  std::vector<std::ptrdiff_t> source_;  // of each entry in A_'s values; -1: a constraint's
  Eigen::VectorXd right_;
};

}  // namespace

std::string to_string(TjunctionHandling handling) {
  switch (handling) {
    case TjunctionHandling::elementwise:
      return "elementwise";
    case TjunctionHandling::explicit_product:
      return "explicit";
    case TjunctionHandling::multiplier:
      return "multiplier";
    default:
      return "ignored";
  }
}

std::vector<HandlingCost> compare_handlings(const Discretization& d, const Eigen::Matrix3Xd& at,
                                            const Eigen::Matrix3Xd& loads, const std::vector<TjunctionHandling>& which,
                                            const HandlingOptions& options) {
  const Meshes meshes(d, at, loads);
  const auto asks_for = [&](TjunctionHandling handling) { return std::ranges::find(which, handling) != which.end(); };
  BlockSystem elementwise(meshes, TjunctionHandling::elementwise);
  std::optional<ProductSystem> product;
  std::optional<MultiplierSystem> multiplier;
  std::optional<BlockSystem> ignored;
  if (asks_for(TjunctionHandling::explicit_product)) product.emplace(meshes);
  if (asks_for(TjunctionHandling::multiplier)) multiplier.emplace(meshes);
  if (asks_for(TjunctionHandling::ignored)) ignored.emplace(meshes, TjunctionHandling::ignored);
  for (int repetition = 0; repetition < options.repetitions; ++repetition) {
    elementwise.repeat();
    if (product) product->repeat();
    if (multiplier) multiplier->repeat();
    if (ignored) ignored->repeat();
  }
  if (options.iterate) {
    elementwise.iterate(options);
    if (product) product->iterate(options);
    if (multiplier) multiplier->iterate(options);
    if (ignored) ignored->iterate(options);
  }
  const HandlingCost reference = elementwise.finished();
  std::vector<HandlingCost> costs;
  for (const TjunctionHandling handling : which) {
    if (handling == TjunctionHandling::elementwise) {
      costs.push_back(reference);
      continue;
    }
    HandlingCost cost = handling == TjunctionHandling::explicit_product ? product->finished()
                        : handling == TjunctionHandling::multiplier     ? multiplier->finished()
                                                                        : ignored->finished();
    if (cost.solved && reference.solved) cost.difference = (cost.u - reference.u).norm() / reference.u.norm();
    costs.push_back(std::move(cost));
  }
  return costs;
}

}  // namespace finegauge
