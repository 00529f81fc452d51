#include "core/solve/multigrid.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "core/mesh/nested_meshes.hpp"
#include "core/parallel/for_parts.hpp"
#include "core/space/block_kernels.hpp"
#include "core/space/transfer.hpp"

namespace finegauge {
namespace {

/// Cells of the mesh of every height (RefinementForest::leaf_mesh), from the heights of the forest.
std::vector<int> cell_counts(const RefinementForest& forest, const std::vector<int>& heights) {
  const int base_cells = static_cast<int>(forest.base().cells.size());
  const int levels = 1 + *std::max_element(heights.begin(), heights.begin() + base_cells);
  std::vector<int> change(levels + 1, 0);
  std::vector<int> open(base_cells);
  for (int cell = 0; cell < base_cells; ++cell) open[cell] = cell;
  change[levels] = base_cells;
  while (!open.empty()) {
    const int handle = open.back();
    open.pop_back();
    const auto& cell = forest.cell(handle);
    if (cell.first_child < 0) continue;
    // Below the height of a cell its children stand in its place.
    change[heights[handle] - 1] += cell.refinement.child_count() - 1;
    for (int k = 0; k < cell.refinement.child_count(); ++k) open.push_back(cell.first_child + k);
  }
  std::vector<int> counts(levels);
  for (int height = levels - 1, cells = base_cells; height >= 0; --height) counts[height] = cells += change[height];
  return counts;
}

Prolongation interpolate(const Discretization& coarse, const Discretization& fine) {
  struct Parent {
    int coarse_cell = -1, fine_cell = -1, corner = -1;
  };
  std::vector<Parent> parents(fine.hanging.reduced_count());
  const int corners = corner_count(fine.mesh.shape);
  visit_nested_leaves(coarse.mesh, fine.mesh, [&](int coarse_cell, int fine_cell) {
    for (int c = 0; c < corners; ++c)
      if (const int reduced = fine.hanging.reduced_of[fine.mesh.cells[fine_cell][c]]; reduced >= 0)
        if (parents[reduced].coarse_cell < 0) parents[reduced] = {coarse_cell, fine_cell, c};
  });
  Prolongation P;
  P.row_start.reserve(parents.size() + 1);
  P.column.reserve(parents.size() * 4);
  P.weight.reserve(parents.size() * 4);
  P.row_start.push_back(0);
  for (const auto& [coarse_cell, fine_cell, corner] : parents) {
    const LeafFrame &outer = coarse.mesh.frames[coarse_cell], &inner = fine.mesh.frames[fine_cell];
    std::array<double, max_corners> N{};
    if (outer.depth == inner.depth)
      N[corner] = 1.0;
    else
      N = shape_functions(fine.mesh.shape,
                          natural_coordinates(fine.mesh.shape, outer, lattice_corner(fine.mesh.shape, inner, corner)));
    const auto first = static_cast<std::ptrdiff_t>(P.column.size());
    for (int a = 0; a < corners; ++a) {
      if (N[a] == 0.0) continue;
      const int node = coarse.mesh.cells[coarse_cell][a];
      for (int k = coarse.hanging.row_start[node]; k < coarse.hanging.row_start[node + 1]; ++k) {
        const int master = coarse.hanging.master[k];
        const float weight = static_cast<float>(N[a] * coarse.hanging.weight[k]);
        const auto found = std::find(P.column.begin() + first, P.column.end(), master);
        if (found != P.column.end()) {
          P.weight[found - P.column.begin()] += weight;
        } else {
          P.column.push_back(master);
          P.weight.push_back(weight);
        }
      }
    }
    P.row_start.push_back(static_cast<int>(P.column.size()));
  }
  return P;
}

}  // namespace

MeshHierarchy build_hierarchy(const RefinementForest& forest, const Discretization& fine,
                              const std::vector<SupportCondition>& supports, const HierarchyOptions& options) {
  MeshHierarchy hierarchy;
  const std::vector<int> heights = forest.heights();
  const std::vector<int> counts = cell_counts(forest, heights);
  int reduced = fine.hanging.reduced_count(), cells = counts[0];
  for (int height = 1; height < static_cast<int>(counts.size()) && reduced > options.smallest; ++height) {
    const bool last = height + 1 == static_cast<int>(counts.size());
    if (counts[height] > options.reduction * cells && !last) continue;
    hierarchy.coarse.push_back(discretize(forest, forest.leaf_mesh(height, heights), fine.shapes.material(), supports));
    hierarchy.coarse.back().springs = springs_on(fine.springs, hierarchy.coarse.back().mesh);
    reduced = hierarchy.coarse.back().hanging.reduced_count();
    cells = counts[height];
  }
  for (std::size_t level = 0; level < hierarchy.coarse.size(); ++level)
    hierarchy.prolongations.push_back(
        interpolate(hierarchy.coarse[level], level == 0 ? fine : hierarchy.coarse[level - 1]));
  return hierarchy;
}

constexpr int rows_per_thread = worth_a_thread(30);

/// A mesh of the cycle with its matrix in single precision; the vectors end in one scalar of padding.
struct Multigrid::Level {
  const BlockPattern* pattern;
  const Supports* supports;
  const Prolongation* prolongation;  // from the next coarser level
  std::vector<float> values;
  std::vector<float> inverse_diagonal;  // 3 × 3 blocks by columns
  std::vector<float> x, b, r;

  Level(const BlockMatrix<double>& A, const Supports& held, const Prolongation* to_coarser)
      : pattern(A.pattern), supports(&held), prolongation(to_coarser), values(A.values.begin(), A.values.end()) {
    const int n = pattern->size();
    inverse_diagonal.resize(9 * static_cast<std::size_t>(n) + 4);
    for_parts(n, rows_per_thread, [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        const Eigen::Matrix3f inverse = A.block(pattern->diagonal[i]).inverse().cast<float>();
        std::copy_n(inverse.data(), 9, inverse_diagonal.begin() + 9 * static_cast<std::ptrdiff_t>(i));
      }
    });
    x.assign(3 * static_cast<std::size_t>(n) + 1, 0.0f);
    b = r = x;
  }

  void store(int i, std::vector<float>& vector, const Lanes<float>& row) const {
    for (int k = 0; k < 3; ++k) vector[3 * static_cast<std::size_t>(i) + k] = row[k];
  }
  /// b_i minus the blocks [first, last) of row i times x.
  Lanes<float> remainder(int i, int first, int last) const {
    Lanes<float> sum = {}, row;
    multiply_row(values.data(), pattern->column.data(), first, last, x.data(), sum);
    load_lanes(b.data() + 3 * static_cast<std::size_t>(i), row);
    return row - sum;
  }
  void solve_diagonal(int i, const Lanes<float>& right) {
    const float* inverse = inverse_diagonal.data() + 9 * static_cast<std::size_t>(i);
    Lanes<float> c0, c1, c2;
    load_lanes(inverse, c0);
    load_lanes(inverse + 3, c1);
    load_lanes(inverse + 6, c2);
    store(i, x, c0 * right[0] + c1 * right[1] + c2 * right[2]);
  }

  /// x = (D + L)⁻¹ b: a forward sweep from zero needs the lower triangle only.
  void sweep_forward_from_zero() {
    for (int i = 0; i < pattern->size(); ++i)
      solve_diagonal(i, remainder(i, pattern->row_start[i], pattern->diagonal[i]));
  }
  /// r = b - A x right after that sweep: what the lower triangle and the diagonal took is gone, - U x remains.
  void residual_after_forward_sweep() {
    for_parts(pattern->size(), rows_per_thread, [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        Lanes<float> sum = {};
        multiply_row(values.data(), pattern->column.data(), pattern->diagonal[i] + 1, pattern->row_start[i + 1],
                     x.data(), sum);
        store(i, r, -sum);
      }
    });
  }
  void sweep_backward() {
    for (int i = pattern->size() - 1; i >= 0; --i) {
      Lanes<float> sum = {}, row;
      multiply_row(values.data(), pattern->column.data(), pattern->row_start[i], pattern->diagonal[i], x.data(), sum);
      multiply_row(values.data(), pattern->column.data(), pattern->diagonal[i] + 1, pattern->row_start[i + 1], x.data(),
                   sum);
      load_lanes(b.data() + 3 * static_cast<std::size_t>(i), row);
      solve_diagonal(i, row - sum);
    }
  }
  /// coarse b = Z Pᵀ r.
  void restrict_to(Level& coarse) const {
    std::fill(coarse.b.begin(), coarse.b.end(), 0.0f);
    for (int i = 0; i < pattern->size(); ++i)
      for (int k = prolongation->row_start[i]; k < prolongation->row_start[i + 1]; ++k)
        for (int axis = 0; axis < 3; ++axis)
          coarse.b[3 * static_cast<std::size_t>(prolongation->column[k]) + axis] +=
              prolongation->weight[k] * r[3 * static_cast<std::size_t>(i) + axis];
    for (std::size_t s = 0; s < coarse.supports->reduced.size(); ++s) {
      Eigen::Map<Eigen::Vector3f> at(coarse.b.data() + 3 * static_cast<std::size_t>(coarse.supports->reduced[s]));
      at -= (coarse.supports->held[s].cast<float>() * at).eval();
    }
  }
  /// x += P coarse x.
  void correct_from(const Level& coarse) {
    for_parts(pattern->size(), rows_per_thread, [&](int first, int last) {
      for (int i = first; i < last; ++i)
        for (int k = prolongation->row_start[i]; k < prolongation->row_start[i + 1]; ++k)
          for (int axis = 0; axis < 3; ++axis)
            x[3 * static_cast<std::size_t>(i) + axis] +=
                prolongation->weight[k] * coarse.x[3 * static_cast<std::size_t>(prolongation->column[k]) + axis];
    });
  }
};

Multigrid::Multigrid(const Discretization& fine, const BlockMatrix<double>& fine_matrix, const Eigen::Matrix3Xd& u,
                     const MeshHierarchy& hierarchy, FactorCache& factors) {
  const auto prolongation_below = [&](std::size_t level) {
    return level < hierarchy.prolongations.size() ? &hierarchy.prolongations[level] : nullptr;
  };
  levels_.push_back(std::make_unique<Level>(fine_matrix, fine.supports, prolongation_below(0)));
  const bool linear = fine.shapes.material().kinematics == Kinematics::linear;
  std::unique_ptr<BlockMatrix<double>> coarse_matrix;
  for (std::size_t level = 0; level < hierarchy.coarse.size(); ++level) {
    const Discretization& coarse = hierarchy.coarse[level];
    const Eigen::Matrix3Xd coarse_u =
        linear ? Eigen::Matrix3Xd::Zero(3, coarse.mesh.node_count()).eval() : transfer(fine.mesh, u, coarse.mesh);
    coarse_matrix = std::make_unique<BlockMatrix<double>>(assemble_stiffness(coarse, coarse_u));
    apply_supports(coarse.supports, *coarse_matrix);
    levels_.push_back(std::make_unique<Level>(*coarse_matrix, coarse.supports, prolongation_below(level + 1)));
  }
  coarsest_ = factors.factor(coarse_matrix ? *coarse_matrix : fine_matrix);
}

Multigrid::~Multigrid() = default;
Multigrid::Multigrid(Multigrid&&) noexcept = default;

bool Multigrid::usable() const { return coarsest_->factored(); }

void Multigrid::apply(const Eigen::VectorXd& r, Eigen::VectorXd& z) {
  if (levels_.size() == 1) {
    z = coarsest_->solve(r);
    return;
  }
  // Scaled to the residual's size, so that single precision neither overflows nor loses small residuals.
  const double scale = r.lpNorm<Eigen::Infinity>();
  if (!(scale > 0.0)) {
    z.setZero(r.size());
    return;
  }
  for (Eigen::Index i = 0; i < r.size(); ++i) levels_[0]->b[i] = static_cast<float>(r[i] / scale);
  const std::size_t last = levels_.size() - 1;
  for (std::size_t level = 0; level < last; ++level) {
    levels_[level]->sweep_forward_from_zero();
    levels_[level]->residual_after_forward_sweep();
    levels_[level]->restrict_to(*levels_[level + 1]);
  }
  Level& bottom = *levels_[last];
  const Eigen::Index n = 3 * bottom.pattern->size();
  const Eigen::VectorXd right = Eigen::Map<const Eigen::VectorXf>(bottom.b.data(), n).cast<double>();
  Eigen::Map<Eigen::VectorXf>(bottom.x.data(), n) = coarsest_->solve(right).cast<float>();
  for (std::size_t level = last; level-- > 0;) {
    levels_[level]->correct_from(*levels_[level + 1]);
    levels_[level]->sweep_backward();
  }
  z.resize(r.size());
  for (Eigen::Index i = 0; i < r.size(); ++i) z[i] = scale * static_cast<double>(levels_[0]->x[i]);
}

}  // namespace finegauge
