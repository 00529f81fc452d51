#include "core/space/assembly.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/parallel/for_parts.hpp"
#include "core/space/cell_sums.hpp"

namespace finegauge {
namespace {

/// A cell's stiffness in the global frame: blocks R K_ab Rᵀ, or K itself without rotations; and its springs', which do
/// not turn with the cell.
class CurrentStiffness {
 public:
  CurrentStiffness(const Discretization& d, const Eigen::Matrix3Xd& u) : d_(d), u_(u) {}

  const CellMatrix& of(int cell) {
    const RestShapes::CellView entry = d_.shapes.entry(d_.mesh, cell, scratch_);
    if (d_.shapes.material().kinematics == Kinematics::linear) return with_springs(cell, entry.stiffness);
    const Eigen::Matrix3d R = cell_motion(d_, cell, entry.geometry, u_).R;
    const int corners = corner_count(d_.mesh.shape);
    for (int b = 0; b < corners; ++b)
      for (int a = 0; a < corners; ++a)
        turned_.block<3, 3>(3 * a, 3 * b).noalias() =
            R * entry.stiffness.block<3, 3>(3 * a, 3 * b).eval() * R.transpose();
    return with_springs(cell, turned_);
  }

 private:
  const CellMatrix& with_springs(int cell, const CellMatrix& tissue) {
    const SpringMatrix* springs = d_.springs.matrix_of(cell);
    if (!springs) return tissue;
    sprung_ = tissue;
    for (int b = 0; b < max_corners; ++b)
      for (int a = 0; a < max_corners; ++a)
        for (int k = 0; k < 3; ++k) sprung_(3 * a + k, 3 * b + k) += (*springs)(a, b);
    return sprung_;
  }

  const Discretization& d_;
  const Eigen::Matrix3Xd& u_;
  RestShapes::Entry scratch_;
  CellMatrix turned_ = CellMatrix::Zero();
  CellMatrix sprung_;
};

/// Adds the block (a, b) of a cell's matrix to a stored block.
inline void add_block(const CellMatrix& K, int a, int b, double* block) {
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) block[3 * c + r] += K(3 * a + r, 3 * b + c);
}

/// Rows of T of a cell's corners, by place among the cell's reduced nodes.
struct CornerWeights {
  int count = 0;  // reduced nodes of the cell
  std::array<std::vector<std::pair<int, double>>, max_corners> rows;
};

void find_corner_weights(const Discretization& d, int cell, CornerWeights& weights) {
  const int begin = d.scatter.node_start[cell], end = d.scatter.node_start[cell + 1];
  weights.count = end - begin;
  for (int c = 0; c < corner_count(d.mesh.shape); ++c) {
    weights.rows[c].clear();
    const int node = d.mesh.cells[cell][c];
    for (int k = d.hanging.row_start[node]; k < d.hanging.row_start[node + 1]; ++k) {
      const auto place =
          std::lower_bound(d.scatter.nodes.begin() + begin, d.scatter.nodes.begin() + end, d.hanging.master[k]) -
          (d.scatter.nodes.begin() + begin);
      weights.rows[c].emplace_back(static_cast<int>(place), d.hanging.weight[k]);
    }
  }
}

/// Row a of a cell's m × m blocks onto their places. K is the cell's own matrix or T_eᵀ K T_e.
inline void add_row(const CellMatrix& K, int a, int m, const int* position, BlockMatrix<double>& A) {
  for (int b = 0; b < m; ++b) add_block(K, a, b, A.values.data() + 9 * static_cast<std::size_t>(position[b]));
}
inline void add_row(const Eigen::MatrixXd& TKT, int a, int m, const int* position, BlockMatrix<double>& A) {
  for (int b = 0; b < m; ++b) A.block(position[b]) += TKT.block<3, 3>(3 * a, 3 * b);
}

/// Rows of cells that are to be added later, in the order in which they were given.
class DeferredRows {
 public:
  template <class Matrix>
  void add(const Matrix& K, int a, int m, const int* position) {
    rows_.push_back({position, m});
    for (int b = 0; b < m; ++b)
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) values_.push_back(K(3 * a + r, 3 * b + c));
  }
  void add_to(BlockMatrix<double>& A) const {
    const double* value = values_.data();
    for (const auto& [position, m] : rows_)
      for (int b = 0; b < m; ++b) {
        double* block = A.values.data() + 9 * static_cast<std::size_t>(position[b]);
        for (int k = 0; k < 9; ++k) block[k] += *value++;
      }
  }

 private:
  struct Row {
    const int* position;
    int m;
  };
  std::vector<Row> rows_;
  std::vector<double> values_;
};

/// T_eᵀ K T_e of a cell with hanging corners.
class HangingCell {
 public:
  HangingCell(const Discretization& d, const Eigen::Matrix3Xd& u) : d_(d), stiffness_(d, u) {}

  const Eigen::MatrixXd& of(int cell) {
    const CellMatrix& K = stiffness_.of(cell);
    const int corners = corner_count(d_.mesh.shape);
    find_corner_weights(d_, cell, weights_);
    KT_.setZero(24, 3 * weights_.count);
    for (int b = 0; b < corners; ++b)
      for (const auto& [place, weight] : weights_.rows[b])
        KT_.middleCols<3>(3 * place) += weight * K.middleCols<3>(3 * b);
    TKT_.setZero(3 * weights_.count, 3 * weights_.count);
    for (int a = 0; a < corners; ++a)
      for (const auto& [place, weight] : weights_.rows[a])
        TKT_.middleRows<3>(3 * place) += weight * KT_.middleRows<3>(3 * a);
    return TKT_;
  }

 private:
  const Discretization& d_;
  CurrentStiffness stiffness_;
  CornerWeights weights_;
  Eigen::Matrix<double, 24, Eigen::Dynamic> KT_;  // K T_e
  Eigen::MatrixXd TKT_;                           // T_eᵀ K T_e
};

/// Adds the matrices of some cells, at each place of A in the order of the cells. Each of several threads takes a range
/// of them. A row belongs to the first range that has it; what others have for it waits until that one is done.
template <class CellOf>
void assemble_cells(const Discretization& d, const Eigen::Matrix3Xd& u, const std::vector<int>& cells,
                    BlockMatrix<double>& A) {
  const auto nodes_of = [&](int cell) {
    const int* nodes = d.scatter.nodes.data();
    return std::span(nodes + d.scatter.node_start[cell], nodes + d.scatter.node_start[cell + 1]);
  };
  const int count = static_cast<int>(cells.size());
  const int ranges = std::clamp(count / cells_per_thread, 1, thread_count());
  const auto first_of = [&](int range) {
    return static_cast<std::size_t>(static_cast<std::int64_t>(count) * range / ranges);
  };
  std::vector<int> owner;  // per row; one range owns all
  if (ranges > 1) {
    owner.assign(static_cast<std::size_t>(d.pattern.size()), ranges);
    for (int range = 0; range < ranges; ++range)
      for (std::size_t k = first_of(range); k < first_of(range + 1); ++k)
        for (const int node : nodes_of(cells[k])) owner[node] = std::min(owner[node], range);
  }
  std::vector<DeferredRows> deferred(static_cast<std::size_t>(ranges > 1 ? ranges : 0));
  for_parts(ranges, 1, [&](int begin, int end) {
    CellOf matrix(d, u);
    for (int range = begin; range < end; ++range)
      for (std::size_t k = first_of(range); k < first_of(range + 1); ++k) {
        const auto& K = matrix.of(cells[k]);
        const std::span<const int> nodes = nodes_of(cells[k]);
        const int m = static_cast<int>(nodes.size());
        const int* position = d.scatter.positions.data() + d.scatter.pair_start[cells[k]];
        for (int a = 0; a < m; ++a, position += m)
          if (owner.empty() || owner[nodes[a]] == range)
            add_row(K, a, m, position, A);
          else
            deferred[range].add(K, a, m, position);
      }
  });
  for (const DeferredRows& rows : deferred) rows.add_to(A);
}

}  // namespace

void assemble_regular_cells(const Discretization& d, const Eigen::Matrix3Xd& u, BlockMatrix<double>& A) {
  assemble_cells<CurrentStiffness>(d, u, d.scatter.regular, A);
}

void assemble_hanging_cells(const Discretization& d, const Eigen::Matrix3Xd& u, BlockMatrix<double>& A) {
  assemble_cells<HangingCell>(d, u, d.scatter.hanging, A);
}

BlockMatrix<double> assemble_stiffness(const Discretization& d, const Eigen::Matrix3Xd& u) {
  BlockMatrix<double> A;
  A.reset(d.pattern);
  assemble_regular_cells(d, u, A);
  assemble_hanging_cells(d, u, A);
  return A;
}

void apply_supports(const Supports& supports, BlockMatrix<double>& A) {
  const BlockPattern& pattern = *A.pattern;
  // Rows Z A, and the mirrored blocks A Z; a block between two supported nodes gets both.
  for (std::size_t s = 0; s < supports.reduced.size(); ++s) {
    const int i = supports.reduced[s];
    const Eigen::Matrix3d Z = Eigen::Matrix3d::Identity() - supports.held[s];
    const double kappa = A.block(pattern.diagonal[i]).trace() / 3.0;
    for (int p = pattern.row_start[i]; p < pattern.row_start[i + 1]; ++p) {
      const int j = pattern.column[p];
      A.block(p) = (Z * A.block(p)).eval();
      if (j == i) {
        A.block(p) = (A.block(p) * Z + kappa * supports.held[s]).eval();
        continue;
      }
      const auto row = pattern.column.begin() + pattern.row_start[j];
      const auto found = std::lower_bound(row, pattern.column.begin() + pattern.row_start[j + 1], i);
      const int mirrored = static_cast<int>(found - pattern.column.begin());
      A.block(mirrored) = (A.block(mirrored) * Z).eval();
    }
  }
}

Eigen::Matrix3Xd internal_forces(const Discretization& d, const Eigen::Matrix3Xd& u) {
  auto [forces] = sum_over_cells<1>(d, [&](int cell, const RestShapes::CellView& entry) {
    const auto [X, x, R] = cell_motion(d, cell, entry.geometry, u);
    return std::array{cell_force(entry.stiffness, R, X, x)};
  });
  add_spring_forces(d.springs, d.mesh, u, forces);
  return forces;
}

double strain_energy_product(const Discretization& d, const Eigen::Matrix3Xd& u) {
  double product = 0.0;
  RestShapes::Entry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const RestShapes::CellView entry = d.shapes.entry(d.mesh, cell, scratch);
    const auto [X, x, R] = cell_motion(d, cell, entry.geometry, u);
    const CellVectors local = R.transpose() * x - X;
    const auto v = local.reshaped();
    product += v.dot(entry.stiffness * v);
  }
  return product;
}

Eigen::SparseMatrix<double> nodal_stiffness(const Discretization& d, const Eigen::Matrix3Xd& u) {
  std::vector<Eigen::Triplet<double>> entries;
  CurrentStiffness stiffness(d, u);
  const int corners = corner_count(d.mesh.shape);
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const CellMatrix& K = stiffness.of(cell);
    for (int i = 0; i < 3 * corners; ++i)
      for (int j = 0; j < 3 * corners; ++j)
        entries.emplace_back(3 * d.mesh.cells[cell][i / 3] + i % 3, 3 * d.mesh.cells[cell][j / 3] + j % 3, K(i, j));
  }
  Eigen::SparseMatrix<double> A(3 * d.mesh.node_count(), 3 * d.mesh.node_count());
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

}  // namespace finegauge
