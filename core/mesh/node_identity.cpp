#include "core/mesh/node_identity.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace finegauge {
namespace {

constexpr std::uint64_t entity(int dimension, int index) {
  return (static_cast<std::uint64_t>(dimension) << 32) | static_cast<std::uint32_t>(index);
}

/// Local edge of the hexahedron along `axis` at the sides (bits by axis) of the two others.
constexpr int hexahedron_edge(int axis, int sides) {
  const int x = sides & 1, y = (sides >> 1) & 1, z = (sides >> 2) & 1;
  return 4 * axis + (axis == 0 ? y + 2 * z : axis == 1 ? x + 2 * z : x + 2 * y);
}

NodeIdentity hexahedron_identity(const BaseMesh& base, const BaseTopology& topology, int base_cell,
                                 const LatticePoint& point) {
  constexpr std::uint64_t unit = lattice_unit(CellShape::hexahedron);
  int inner[3], inner_count = 0, sides = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (point[axis] == unit)
      sides |= 1 << axis;
    else if (point[axis] != 0)
      inner[inner_count++] = axis;
  }
  const auto& corners = base.cells[base_cell];
  if (inner_count == 3) return {entity(3, base_cell), point};
  if (inner_count == 0) return {entity(0, corners[sides]), {0, 0, 0}};
  if (inner_count == 1) {
    const int axis = inner[0];
    const bool reversed = corners[sides] > corners[sides | (1 << axis)];
    return {entity(1, topology.cell_edges[base_cell][hexahedron_edge(axis, sides)]),
            {reversed ? unit - point[axis] : point[axis], 0, 0}};
  }
  const int axis = 3 - inner[0] - inner[1];
  const auto& view = topology.cell_faces[base_cell][2 * axis + ((sides >> axis) & 1)];
  std::uint64_t s = point[(axis + 1) % 3], t = point[(axis + 2) % 3];
  if (view.swap) std::swap(s, t);
  return {entity(2, view.face), {view.flip[0] ? unit - s : s, view.flip[1] ? unit - t : t, 0}};
}

LatticePoint hexahedron_face_point(const BaseTopology::FaceView& view, int face, const LatticePoint& at) {
  constexpr std::uint64_t unit = lattice_unit(CellShape::hexahedron);
  std::uint64_t s = view.flip[0] ? unit - at[0] : at[0], t = view.flip[1] ? unit - at[1] : at[1];
  if (view.swap) std::swap(s, t);
  const int axis = face / 2;
  LatticePoint point{};
  point[axis] = face % 2 ? unit : 0;
  point[(axis + 1) % 3] = s;
  point[(axis + 2) % 3] = t;
  return point;
}

/// Barycentric coordinates in lattice units.
std::array<std::uint64_t, 4> barycentric(const LatticePoint& point) {
  return {lattice_unit(CellShape::tetrahedron) - point[0] - point[1] - point[2], point[0], point[1], point[2]};
}

NodeIdentity tetrahedron_identity(const BaseMesh& base, const BaseTopology& topology, int base_cell,
                                  const LatticePoint& point) {
  const auto weights = barycentric(point);
  const auto& nodes = base.cells[base_cell];
  std::array<int, 4> corners{};
  int count = 0, zero_corner = -1;
  for (int c = 0; c < 4; ++c) {
    if (weights[c] == 0) {
      zero_corner = c;
      continue;
    }
    int place = count++;  // insertion, ascending by global node
    for (; place > 0 && nodes[corners[place - 1]] > nodes[c]; --place) corners[place] = corners[place - 1];
    corners[place] = c;
  }
  if (count == 4) return {entity(3, base_cell), point};
  if (count == 1) return {entity(0, nodes[corners[0]]), {0, 0, 0}};
  if (count == 3)
    return {entity(2, topology.cell_faces[base_cell][zero_corner].face), {weights[corners[1]], weights[corners[2]], 0}};
  const std::array<int, 2> ends = {std::min(corners[0], corners[1]), std::max(corners[0], corners[1])};
  const auto local = std::find(tetrahedron_edges.begin(), tetrahedron_edges.end(), ends) - tetrahedron_edges.begin();
  return {entity(1, topology.cell_edges[base_cell][local]), {weights[corners[1]], 0, 0}};
}

/// The point with given weights at given global nodes of a tetrahedral base cell.
LatticePoint tetrahedron_point(const BaseMesh& base, int base_cell, std::span<const int> nodes,
                               std::span<const std::uint64_t> weights) {
  LatticePoint point{};
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (int c = 1; c < 4; ++c)
      if (base.cells[base_cell][c] == nodes[k]) point[c - 1] = weights[k];
  return point;
}

std::uint64_t hash(const NodeIdentity& identity) {
  std::uint64_t h = identity.entity * 0x9e3779b97f4a7c15ull;
  for (const std::uint64_t coordinate : identity.at) {
    h ^= coordinate + 0x9e3779b97f4a7c15ull + (h << 6) + (h >> 2);
    h *= 0xff51afd7ed558ccdull;
    h ^= h >> 32;
  }
  return h;
}

}  // namespace

NodeIdentity identity_of(const BaseMesh& base, const BaseTopology& topology, int base_cell, const LatticePoint& point) {
  return base.shape == CellShape::hexahedron ? hexahedron_identity(base, topology, base_cell, point)
                                             : tetrahedron_identity(base, topology, base_cell, point);
}

Eigen::Vector3d position_of(const BaseMesh& base, const BaseTopology& topology, const NodeIdentity& identity) {
  const double unit = static_cast<double>(lattice_unit(base.shape));
  const Eigen::Vector3d s(static_cast<double>(identity.at[0]) / unit, static_cast<double>(identity.at[1]) / unit,
                          static_cast<double>(identity.at[2]) / unit);
  const int index = entity_index(identity);
  switch (entity_dimension(identity)) {
    case 0:
      return base.nodes.col(index);
    case 1: {
      const auto& ends = topology.edges[index];
      return (1.0 - s[0]) * base.nodes.col(ends[0]) + s[0] * base.nodes.col(ends[1]);
    }
    case 2: {
      const auto& nodes = topology.faces[index];
      if (base.shape == CellShape::tetrahedron)
        return (1.0 - s[0] - s[1]) * base.nodes.col(nodes[0]) + s[0] * base.nodes.col(nodes[1]) +
               s[1] * base.nodes.col(nodes[2]);
      return (1.0 - s[1]) * ((1.0 - s[0]) * base.nodes.col(nodes[0]) + s[0] * base.nodes.col(nodes[1])) +
             s[1] * ((1.0 - s[0]) * base.nodes.col(nodes[2]) + s[0] * base.nodes.col(nodes[3]));
    }
    default: {
      const auto N = shape_functions(base.shape, s);
      Eigen::Vector3d x = Eigen::Vector3d::Zero();
      for (int c = 0; c < corner_count(base.shape); ++c) x += N[c] * base.nodes.col(base.cells[index][c]);
      return x;
    }
  }
}

bool on_boundary(const BaseTopology& topology, const NodeIdentity& identity) {
  const int index = entity_index(identity);
  switch (entity_dimension(identity)) {
    case 0:
      return topology.node_on_boundary[index];
    case 1:
      return topology.edge_on_boundary[index];
    case 2:
      return topology.face_cells[index][1].cell < 0;
    default:
      return false;
  }
}

void local_points(const BaseMesh& base, const BaseTopology& topology, const NodeIdentity& identity,
                  std::vector<LocalPoint>& points) {
  points.clear();
  const bool hexahedra = base.shape == CellShape::hexahedron;
  const std::uint64_t unit = lattice_unit(base.shape);
  const int index = entity_index(identity);
  switch (entity_dimension(identity)) {
    case 0:
      for (int k = topology.node_cell_start[index]; k < topology.node_cell_start[index + 1]; ++k) {
        const int cell = topology.node_cells[k];
        const int corner = static_cast<int>(std::find(base.cells[cell].begin(), base.cells[cell].end(), index) -
                                            base.cells[cell].begin());
        LatticePoint point{};
        for (int axis = 0; axis < 3; ++axis)
          if (hexahedra ? (corner >> axis) & 1 : corner == axis + 1) point[axis] = unit;
        points.push_back({cell, point});
      }
      return;
    case 1:
      for (int k = topology.edge_cell_start[index]; k < topology.edge_cell_start[index + 1]; ++k) {
        const int cell = topology.edge_cells[k];
        const std::array<std::uint64_t, 2> weights = {unit - identity.at[0], identity.at[0]};
        if (!hexahedra) {
          points.push_back({cell, tetrahedron_point(base, cell, topology.edges[index], weights)});
          continue;
        }
        const auto& edges = topology.cell_edges[cell];
        const int local = static_cast<int>(std::find(edges.begin(), edges.end(), index) - edges.begin());
        const auto& ends = hexahedron_edges[local];
        LatticePoint point{};
        for (int axis = 0; axis < 3; ++axis) point[axis] = (ends[0] >> axis) & 1 ? unit : 0;
        point[local / 4] = base.cells[cell][ends[0]] > base.cells[cell][ends[1]] ? weights[0] : weights[1];
        points.push_back({cell, point});
      }
      return;
    case 2:
      for (const auto& [cell, face] : topology.face_cells[index]) {
        if (cell < 0) continue;
        if (hexahedra) {
          points.push_back({cell, hexahedron_face_point(topology.cell_faces[cell][face], face, identity.at)});
        } else {
          const std::array<std::uint64_t, 3> weights = {unit - identity.at[0] - identity.at[1], identity.at[0],
                                                        identity.at[1]};
          points.push_back({cell, tetrahedron_point(base, cell, std::span(topology.faces[index]).first(3), weights)});
        }
      }
      return;
    default:
      points.push_back({index, identity.at});
  }
}

NodeNumbers::NodeNumbers(std::size_t expected) {
  identities_.reserve(expected);
  std::size_t size = 64;
  while (size < 2 * expected) size *= 2;
  slots_.assign(size, -1);
}

int NodeNumbers::number(const NodeIdentity& identity) {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t slot = hash(identity) & mask;; slot = (slot + 1) & mask) {
    if (slots_[slot] < 0) {
      slots_[slot] = static_cast<int>(identities_.size());
      identities_.push_back(identity);
      const int fresh = slots_[slot];
      if (2 * identities_.size() > slots_.size()) grow();
      return fresh;
    }
    if (identities_[slots_[slot]] == identity) return slots_[slot];
  }
}

void NodeNumbers::grow() {
  slots_.assign(2 * slots_.size(), -1);
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t i = 0; i < identities_.size(); ++i) {
    std::size_t slot = hash(identities_[i]) & mask;
    while (slots_[slot] >= 0) slot = (slot + 1) & mask;
    slots_[slot] = static_cast<int>(i);
  }
}

}  // namespace finegauge
