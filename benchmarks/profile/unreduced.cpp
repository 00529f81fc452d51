#include "benchmarks/profile/unreduced.hpp"

#include <algorithm>
#include <numeric>

namespace finegauge {
namespace {

/// The nodes that share a cell with each node, itself included.
BlockPattern neighbour_pattern(const Mesh& mesh) {
  const NodeCells around = cells_around_nodes(mesh);
  const int corners = corner_count(mesh.shape);
  BlockPattern pattern;
  pattern.row_start.assign(1, 0);
  std::vector<int> row;
  for (int node = 0; node < mesh.node_count(); ++node) {
    row.clear();
    for (int k = around.start[node]; k < around.start[node + 1]; ++k) {
      const auto& cell = mesh.cells[around.cells[k]];
      row.insert(row.end(), cell.begin(), cell.begin() + corners);
    }
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    const auto diagonal = std::lower_bound(row.begin(), row.end(), node) - row.begin();
    pattern.diagonal.push_back(pattern.block_count() + static_cast<int>(diagonal));
    pattern.column.insert(pattern.column.end(), row.begin(), row.end());
    pattern.row_start.push_back(pattern.block_count());
  }
  return pattern;
}

CellScatter corner_scatter(const Mesh& mesh, const BlockPattern& pattern) {
  const int corners = corner_count(mesh.shape);
  CellScatter scatter;
  scatter.node_start.push_back(0);
  scatter.pair_start.push_back(0);
  for (const auto& cell : mesh.cells) {
    scatter.nodes.insert(scatter.nodes.end(), cell.begin(), cell.begin() + corners);
    for (int a = 0; a < corners; ++a) {
      const auto row = pattern.column.begin() + pattern.row_start[cell[a]];
      const auto end = pattern.column.begin() + pattern.row_start[cell[a] + 1];
      for (int b = 0; b < corners; ++b)
        scatter.positions.push_back(static_cast<int>(std::lower_bound(row, end, cell[b]) - pattern.column.begin()));
    }
    scatter.node_start.push_back(static_cast<int>(scatter.nodes.size()));
    scatter.pair_start.push_back(scatter.positions.size());
  }
  scatter.regular.resize(mesh.cells.size());
  std::iota(scatter.regular.begin(), scatter.regular.end(), 0);
  return scatter;
}

}  // namespace

HangingNodes nodes_as_they_are(const Mesh& mesh) {
  HangingNodes identity;
  identity.row_start.resize(mesh.node_count() + 1);
  identity.master.resize(mesh.node_count());
  std::iota(identity.row_start.begin(), identity.row_start.end(), 0);
  std::iota(identity.master.begin(), identity.master.end(), 0);
  identity.weight.assign(mesh.node_count(), 1.0);
  identity.reduced_of = identity.node_of = identity.master;
  return identity;
}

Discretization unreduced(const Discretization& d) {
  Discretization free = d;
  free.hanging = nodes_as_they_are(d.mesh);
  for (int& node : free.supports.reduced) node = d.hanging.node_of[node];  // stays ascending, as node_of is
  free.pattern = neighbour_pattern(d.mesh);
  free.scatter = corner_scatter(d.mesh, free.pattern);
  return free;
}

}  // namespace finegauge
