#include "core/mesh/base_topology.hpp"

#include <algorithm>
#include <map>

namespace finegauge {
namespace {

/// Canonical view of a quadrilateral whose local corners (0,0) (1,0) (0,1) (1,1) are the nodes n.
BaseTopology::FaceView view_of(const std::array<int, 4>& n) {
  const int smallest = static_cast<int>(std::min_element(n.begin(), n.end()) - n.begin());
  const bool flip_a = smallest & 1, flip_b = smallest & 2;
  const bool swap = n[smallest ^ 2] < n[smallest ^ 1];
  return {-1, swap, swap ? std::array<bool, 2>{flip_b, flip_a} : std::array<bool, 2>{flip_a, flip_b}};
}

std::array<int, 4> canonical_nodes(const std::array<int, 4>& n, const BaseTopology::FaceView& view) {
  std::array<int, 4> canonical{};
  for (int corner = 0; corner < 4; ++corner) {
    bool s = corner & 1, t = corner & 2;
    if (view.swap) std::swap(s, t);
    s ^= view.flip[0];
    t ^= view.flip[1];
    canonical[(s ? 1 : 0) + (t ? 2 : 0)] = n[corner];
  }
  return canonical;
}

/// Compressed rows from (row, value) pairs given in the order in which they shall stand.
void compress(int rows, const std::vector<std::array<int, 2>>& pairs, std::vector<int>& start,
              std::vector<int>& values) {
  start.assign(rows + 1, 0);
  for (const auto& [row, value] : pairs) ++start[row + 1];
  for (int row = 0; row < rows; ++row) start[row + 1] += start[row];
  values.resize(pairs.size());
  std::vector<int> next(start.begin(), start.end() - 1);
  for (const auto& [row, value] : pairs) values[next[row]++] = value;
}

}  // namespace

BaseTopology base_topology(const BaseMesh& mesh) {
  BaseTopology topology;
  const int cells = static_cast<int>(mesh.cells.size());
  const bool hexahedra = mesh.shape == CellShape::hexahedron;
  topology.cell_edges.resize(cells);
  topology.cell_faces.resize(cells);
  std::map<std::array<int, 2>, int> edge_numbers;
  std::map<std::array<int, 4>, int> face_numbers;
  std::vector<std::array<int, 2>> edge_pairs, node_pairs;

  for (int cell = 0; cell < cells; ++cell) {
    const auto& corners = mesh.cells[cell];
    for (int c = 0; c < corner_count(mesh.shape); ++c) node_pairs.push_back({corners[c], cell});
    for (int e = 0; e < edge_count(mesh.shape); ++e) {
      const auto& ends = edge_corners(mesh.shape, e);
      const std::array<int, 2> key = {std::min(corners[ends[0]], corners[ends[1]]),
                                      std::max(corners[ends[0]], corners[ends[1]])};
      const auto [found, fresh] = edge_numbers.try_emplace(key, static_cast<int>(topology.edges.size()));
      if (fresh) topology.edges.push_back(key);
      topology.cell_edges[cell][e] = found->second;
      edge_pairs.push_back({found->second, cell});
    }
    for (int f = 0; f < face_count(mesh.shape); ++f) {
      const auto& local = face_corners(mesh.shape, f);
      std::array<int, 4> nodes = {-1, -1, -1, -1};
      for (int k = 0; k < face_corner_count(mesh.shape); ++k) nodes[k] = corners[local[k]];
      BaseTopology::FaceView view{-1, false, {false, false}};
      if (hexahedra) {
        view = view_of(nodes);
        nodes = canonical_nodes(nodes, view);
      } else {
        std::sort(nodes.begin(), nodes.begin() + 3);
      }
      const auto [found, fresh] = face_numbers.try_emplace(nodes, static_cast<int>(topology.faces.size()));
      if (fresh) {
        topology.faces.push_back(nodes);
        topology.face_cells.push_back({BaseFace{cell, f}, BaseFace{-1, -1}});
      } else {
        topology.face_cells[found->second][1] = {cell, f};
      }
      view.face = found->second;
      topology.cell_faces[cell][f] = view;
    }
  }
  compress(static_cast<int>(topology.edges.size()), edge_pairs, topology.edge_cell_start, topology.edge_cells);
  compress(static_cast<int>(mesh.nodes.cols()), node_pairs, topology.node_cell_start, topology.node_cells);

  topology.node_on_boundary.assign(mesh.nodes.cols(), 0);
  topology.edge_on_boundary.assign(topology.edges.size(), 0);
  for (const auto& sides : topology.face_cells) {
    if (sides[1].cell >= 0) continue;
    const auto [cell, face] = sides[0];
    const auto& local = face_corners(mesh.shape, face);
    const auto on_face = [&](int corner) {
      return std::find(local.begin(), local.begin() + face_corner_count(mesh.shape), corner) !=
             local.begin() + face_corner_count(mesh.shape);
    };
    for (int k = 0; k < face_corner_count(mesh.shape); ++k) topology.node_on_boundary[mesh.cells[cell][local[k]]] = 1;
    for (int e = 0; e < edge_count(mesh.shape); ++e) {
      const auto& ends = edge_corners(mesh.shape, e);
      if (on_face(ends[0]) && on_face(ends[1])) topology.edge_on_boundary[topology.cell_edges[cell][e]] = 1;
    }
  }
  return topology;
}

}  // namespace finegauge
