#include "core/space/discretization.hpp"

#include <algorithm>
#include <utility>

namespace finegauge {
namespace {

/// Reduced nodes of every cell: its corners' masters, corners first in order where none hangs.
void find_cell_nodes(const Mesh& mesh, const HangingNodes& hanging, CellScatter& scatter) {
  const int corners = corner_count(mesh.shape);
  scatter.node_start.reserve(mesh.cell_count() + 1);
  scatter.pair_start.reserve(mesh.cell_count() + 1);
  scatter.nodes.reserve(static_cast<std::size_t>(mesh.cell_count()) * corners * 5 / 4);
  scatter.node_start.push_back(0);
  scatter.pair_start.push_back(0);
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const auto& nodes = mesh.cells[cell];
    const bool any = std::any_of(nodes.begin(), nodes.begin() + corners, [&](int n) { return hanging.hangs(n); });
    (any ? scatter.hanging : scatter.regular).push_back(cell);
    const auto first = scatter.nodes.size();
    for (int c = 0; c < corners; ++c)
      for (int k = hanging.row_start[nodes[c]]; k < hanging.row_start[nodes[c] + 1]; ++k)
        scatter.nodes.push_back(hanging.master[k]);
    if (any) {
      std::sort(scatter.nodes.begin() + first, scatter.nodes.end());
      scatter.nodes.erase(std::unique(scatter.nodes.begin() + first, scatter.nodes.end()), scatter.nodes.end());
    }
    const std::size_t count = scatter.nodes.size() - first;
    scatter.node_start.push_back(static_cast<int>(scatter.nodes.size()));
    scatter.pair_start.push_back(scatter.pair_start.back() + count * count);
  }
}

/// Rows one after the other: the columns that any cell brings, sorted, and then where each cell's pairs have gone.
void build_pattern(int size, CellScatter& scatter, BlockPattern& pattern) {
  const int cells = static_cast<int>(scatter.node_start.size()) - 1;
  struct Visit {
    int cell;
    int place;  // of the row's node among the cell's nodes
  };
  std::vector<int> start(size + 1, 0);
  for (const int node : scatter.nodes) ++start[node + 1];
  for (int i = 0; i < size; ++i) start[i + 1] += start[i];
  std::vector<Visit> visits(scatter.nodes.size());
  {
    std::vector<int> next(start.begin(), start.end() - 1);
    for (int cell = 0; cell < cells; ++cell)
      for (int k = scatter.node_start[cell]; k < scatter.node_start[cell + 1]; ++k)
        visits[next[scatter.nodes[k]]++] = {cell, k - scatter.node_start[cell]};
  }
  scatter.positions.resize(scatter.pair_start.back());
  pattern.row_start.assign(1, 0);
  pattern.row_start.reserve(size + 1);
  pattern.diagonal.resize(size);
  pattern.column.reserve(static_cast<std::size_t>(size) * 28);
  std::vector<int> position(size, -1);  // of a column in the current row, stale entries are below the row's start
  for (int row = 0; row < size; ++row) {
    const int first = pattern.row_start[row];
    for (int v = start[row]; v < start[row + 1]; ++v)
      for (int k = scatter.node_start[visits[v].cell]; k < scatter.node_start[visits[v].cell + 1]; ++k) {
        const int column = scatter.nodes[k];
        if (position[column] >= first) continue;
        position[column] = first;
        pattern.column.push_back(column);
      }
    std::sort(pattern.column.begin() + first, pattern.column.end());
    for (int p = first; p < pattern.block_count(); ++p) position[pattern.column[p]] = p;
    pattern.diagonal[row] = position[row];
    pattern.row_start.push_back(pattern.block_count());
    for (int v = start[row]; v < start[row + 1]; ++v) {
      const auto [cell, place] = visits[v];
      const int begin = scatter.node_start[cell], count = scatter.node_start[cell + 1] - begin;
      int* const positions =
          scatter.positions.data() + scatter.pair_start[cell] + static_cast<std::size_t>(place) * count;
      for (int k = 0; k < count; ++k) positions[k] = position[scatter.nodes[begin + k]];
    }
  }
}

}  // namespace

Discretization discretize(const RefinementForest& forest, const Material& material,
                          const std::vector<SupportCondition>& supports, int height) {
  return discretize(forest, forest.leaf_mesh(height), material, supports);
}

Discretization discretize(const RefinementForest& forest, Mesh mesh, const Material& material,
                          const std::vector<SupportCondition>& supports, const std::vector<SpringSupport>& springs) {
  Discretization d;
  d.mesh = std::move(mesh);
  d.hanging = find_hanging_nodes(forest, d.mesh);
  d.supports = find_supports(forest.base(), d.mesh, d.hanging, supports);
  d.shapes = RestShapes(d.mesh, material);
  find_cell_nodes(d.mesh, d.hanging, d.scatter);
  build_pattern(d.hanging.reduced_count(), d.scatter, d.pattern);
  d.springs = find_springs(forest.base(), d.mesh, springs);
  d.singular_edge = singular_edges_of_cells(forest.base(), forest.topology(), d.mesh, supports, material.poisson_ratio);
  return d;
}

Eigen::Matrix3Xd expand(const HangingNodes& hanging, const Eigen::VectorXd& reduced) {
  Eigen::Matrix3Xd nodal(3, hanging.node_count());
  for (int node = 0; node < hanging.node_count(); ++node) {
    if (const int own = hanging.reduced_of[node]; own >= 0) {
      nodal.col(node) = reduced.segment<3>(3 * own);
      continue;
    }
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    for (int k = hanging.row_start[node]; k < hanging.row_start[node + 1]; ++k)
      value += hanging.weight[k] * reduced.segment<3>(3 * hanging.master[k]);
    nodal.col(node) = value;
  }
  return nodal;
}

Eigen::VectorXd gather(const HangingNodes& hanging, const Eigen::Matrix3Xd& nodal) {
  Eigen::VectorXd reduced(3 * hanging.reduced_count());
  for (int i = 0; i < hanging.reduced_count(); ++i) reduced.segment<3>(3 * i) = nodal.col(hanging.node_of[i]);
  return reduced;
}

Eigen::VectorXd reduce_forces(const HangingNodes& hanging, const Eigen::Matrix3Xd& forces) {
  Eigen::VectorXd reduced = Eigen::VectorXd::Zero(3 * hanging.reduced_count());
  for (int node = 0; node < hanging.node_count(); ++node)
    for (int k = hanging.row_start[node]; k < hanging.row_start[node + 1]; ++k)
      reduced.segment<3>(3 * hanging.master[k]) += hanging.weight[k] * forces.col(node);
  return reduced;
}

void impose(const Supports& supports, Eigen::VectorXd& reduced_displacement) {
  for (std::size_t s = 0; s < supports.reduced.size(); ++s) {
    auto u = reduced_displacement.segment<3>(3 * supports.reduced[s]);
    u = (u - supports.held[s] * u + supports.displacement[s]).eval();
  }
}

void project(const Supports& supports, Eigen::VectorXd& reduced) {
  for (std::size_t s = 0; s < supports.reduced.size(); ++s) {
    auto u = reduced.segment<3>(3 * supports.reduced[s]);
    u = (u - supports.held[s] * u).eval();
  }
}

Eigen::SparseMatrix<double> interpolation_matrix(const HangingNodes& hanging) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int node = 0; node < hanging.node_count(); ++node)
    for (int k = hanging.row_start[node]; k < hanging.row_start[node + 1]; ++k)
      for (int axis = 0; axis < 3; ++axis)
        entries.emplace_back(3 * node + axis, 3 * hanging.master[k] + axis, hanging.weight[k]);
  Eigen::SparseMatrix<double> T(3 * hanging.node_count(), 3 * hanging.reduced_count());
  T.setFromTriplets(entries.begin(), entries.end());
  return T;
}

}  // namespace finegauge
