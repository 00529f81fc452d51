#include "core/space/assembly.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/elasticity/cell_response.hpp"

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
    const CellVectors x = corner_values(d_.mesh, cell, d_.mesh.nodes) + corner_values(d_.mesh, cell, u_);
    const Eigen::Matrix3d R = cell_rotation(entry.geometry, d_.shapes.material(), x);
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

}  // namespace

void assemble_regular_cells(const Discretization& d, const Eigen::Matrix3Xd& u, BlockMatrix<double>& A) {
  CurrentStiffness stiffness(d, u);
  const int corners = corner_count(d.mesh.shape);
  for (const int cell : d.scatter.regular) {
    const CellMatrix& K = stiffness.of(cell);
    const int* position = d.scatter.positions.data() + d.scatter.pair_start[cell];
    for (int a = 0; a < corners; ++a)
      for (int b = 0; b < corners; ++b) add_block(K, a, b, A.values.data() + 9 * static_cast<std::size_t>(*position++));
  }
}

void assemble_hanging_cells(const Discretization& d, const Eigen::Matrix3Xd& u, BlockMatrix<double>& A) {
  CurrentStiffness stiffness(d, u);
  const int corners = corner_count(d.mesh.shape);
  CornerWeights weights;
  Eigen::Matrix<double, 24, Eigen::Dynamic> KT;  // K T_e
  Eigen::MatrixXd TKT;                           // T_eᵀ K T_e
  for (const int cell : d.scatter.hanging) {
    const CellMatrix& K = stiffness.of(cell);
    find_corner_weights(d, cell, weights);
    KT.setZero(24, 3 * weights.count);
    for (int b = 0; b < corners; ++b)
      for (const auto& [place, weight] : weights.rows[b])
        KT.middleCols<3>(3 * place) += weight * K.middleCols<3>(3 * b);
    TKT.setZero(3 * weights.count, 3 * weights.count);
    for (int a = 0; a < corners; ++a)
      for (const auto& [place, weight] : weights.rows[a])
        TKT.middleRows<3>(3 * place) += weight * KT.middleRows<3>(3 * a);
    const int* position = d.scatter.positions.data() + d.scatter.pair_start[cell];
    for (int a = 0; a < weights.count; ++a)
      for (int b = 0; b < weights.count; ++b) A.block(*position++) += TKT.block<3, 3>(3 * a, 3 * b);
  }
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
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  RestShapes::Entry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const RestShapes::CellView entry = d.shapes.entry(d.mesh, cell, scratch);
    // Without rotations only u counts, and in X + u - X it would lose the digits that X has before it.
    const bool turns = d.shapes.material().kinematics == Kinematics::corotational;
    const CellVectors X = turns ? corner_values(d.mesh, cell, d.mesh.nodes) : CellVectors(CellVectors::Zero());
    const CellVectors x = X + corner_values(d.mesh, cell, u);
    const Eigen::Matrix3d R = cell_rotation(entry.geometry, d.shapes.material(), x);
    const CellVectors f = cell_force(entry.stiffness, R, X, x);
    for (int c = 0; c < corner_count(d.mesh.shape); ++c) forces.col(d.mesh.cells[cell][c]) += f.col(c);
  }
  add_spring_forces(d.springs, d.mesh, u, forces);
  return forces;
}

double strain_energy_product(const Discretization& d, const Eigen::Matrix3Xd& u) {
  double product = 0.0;
  RestShapes::Entry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const RestShapes::CellView entry = d.shapes.entry(d.mesh, cell, scratch);
    const bool turns = d.shapes.material().kinematics == Kinematics::corotational;
    const CellVectors X = turns ? corner_values(d.mesh, cell, d.mesh.nodes) : CellVectors(CellVectors::Zero());
    const CellVectors x = X + corner_values(d.mesh, cell, u);
    const Eigen::Matrix3d R = cell_rotation(entry.geometry, d.shapes.material(), x);
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
