#include "core/mesh/base_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "core/mesh/position_text.hpp"

namespace finegauge {

namespace {

void check(const std::array<std::vector<double>, 3>& coordinates, const std::optional<RemovedBlock>& removed) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& x = coordinates[axis];
    std::ostringstream where;
    where.precision(17);
    where << "coordinates along " << axis_names[axis];
    if (x.size() < 2) throw std::invalid_argument(where.str() + ": at least two are needed");
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (std::isfinite(x[i]) && (i == 0 || x[i] > x[i - 1])) continue;
      where << ": number " << i << " is " << x[i] << ", but they must be finite and strictly ascending";
      throw std::invalid_argument(where.str());
    }
  }
  if (!removed) return;
  bool whole = true;
  for (int axis = 0; axis < 3; ++axis) {
    const int first = removed->first[axis], last = removed->last[axis];
    const int n = static_cast<int>(coordinates[axis].size()) - 1;
    if (!(0 <= first && first < last && last <= n)) {
      std::ostringstream message;
      message << "removed block along " << axis_names[axis] << " is [" << first << ", " << last
              << "), but must be a range of lattice cells inside [0, " << n << ")";
      throw std::invalid_argument(message.str());
    }
    whole = whole && first == 0 && last == n;
  }
  if (whole) throw std::invalid_argument("removed block is the whole lattice: no cell is left");
}

/// Cells and nodes are numbered by int.
void check_count(const std::array<int, 3>& cells, CellShape shape) {
  const double per_lattice_cell = shape == CellShape::tetrahedron ? 6.0 : 1.0;
  if (!(per_lattice_cell * (cells[0] + 1.0) * (cells[1] + 1.0) * (cells[2] + 1.0) < 2147483647.0))
    throw std::invalid_argument("cells: the lattice has more than 2^31 - 1 cells or nodes");
}

bool is_removed(const std::optional<RemovedBlock>& removed, const std::array<int, 3>& cell) {
  if (!removed) return false;
  for (int axis = 0; axis < 3; ++axis)
    if (cell[axis] < removed->first[axis] || cell[axis] >= removed->last[axis]) return false;
  return true;
}

/// Cells and nodes are numbered lexicographically, x fastest.
BaseMesh lattice_mesh(const std::array<std::vector<double>, 3>& coordinates, const std::optional<RemovedBlock>& removed,
                      CellShape shape) {
  std::array<int, 3> n;
  for (int axis = 0; axis < 3; ++axis) n[axis] = static_cast<int>(coordinates[axis].size()) - 1;
  const auto lattice_node = [&](int i, int j, int k) { return i + (n[0] + 1) * (j + (n[1] + 1) * k); };

  BaseMesh mesh;
  mesh.shape = shape;
  const auto add_cell = [&](const std::array<int, 8>& corners) {
    if (shape == CellShape::hexahedron) {
      mesh.cells.push_back(corners);
      return;
    }
    for (const auto& path : kuhn_tetrahedra) {
      std::array<int, max_corners> cell;
      cell.fill(-1);
      for (int c = 0; c < 4; ++c) cell[c] = corners[path[c]];
      mesh.cells.push_back(cell);
    }
  };
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        if (is_removed(removed, {i, j, k})) continue;
        std::array<int, 8> corners;
        for (int c = 0; c < 8; ++c) corners[c] = lattice_node(i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2));
        add_cell(corners);
      }

  // Lattice nodes that no cell uses do not become nodes.
  std::vector<int> node_of((n[0] + 1) * (n[1] + 1) * (n[2] + 1), -1);
  for (const auto& cell : mesh.cells)
    for (int c = 0; c < corner_count(shape); ++c) node_of[cell[c]] = 0;
  std::vector<std::array<int, 3>> lattice;
  int next = 0;
  for (int k = 0; k <= n[2]; ++k)
    for (int j = 0; j <= n[1]; ++j)
      for (int i = 0; i <= n[0]; ++i) {
        int& node = node_of[lattice_node(i, j, k)];
        if (node < 0) continue;
        node = next++;
        lattice.push_back({i, j, k});
      }
  mesh.nodes.resize(3, next);
  for (int node = 0; node < next; ++node)
    for (int axis = 0; axis < 3; ++axis) mesh.nodes(axis, node) = coordinates[axis][lattice[node][axis]];
  for (auto& cell : mesh.cells)
    for (int c = 0; c < corner_count(shape); ++c) cell[c] = node_of[cell[c]];

  for (const BaseFace& face : boundary_faces(mesh)) {
    const auto& corners = face_corners(shape, face.face);
    std::string name = "notch";
    for (int axis = 0; axis < 3; ++axis)
      for (const int end : {0, n[axis]}) {
        bool on_plane = true;
        for (int c = 0; c < face_corner_count(shape); ++c)
          on_plane = on_plane && lattice[mesh.cells[face.cell][corners[c]]][axis] == end;
        if (on_plane) name = std::string(axis_names[axis]) + (end == 0 ? "_min" : "_max");
      }
    mesh.surfaces[name].push_back(face);
  }
  return mesh;
}

}  // namespace

BaseMesh box_mesh(const BoxMeshOptions& options) {
  std::array<std::vector<double>, 3> coordinates;
  for (int axis = 0; axis < 3; ++axis) {
    const int n = options.cells[axis];
    const double size = options.size[axis], origin = options.origin[axis];
    std::ostringstream message;
    message.precision(17);
    if (!(n >= 1)) message << "cells along " << axis_names[axis] << " is " << n << ", but must be at least 1";
    if (!(size > 0.0 && std::isfinite(size)))
      message << "size along " << axis_names[axis] << " is " << size << ", but must be positive and finite [m]";
    if (!std::isfinite(origin))
      message << "origin along " << axis_names[axis] << " is " << origin << ", but must be finite [m]";
    if (!message.str().empty()) throw std::invalid_argument(message.str());
  }
  check_count(options.cells, options.shape);
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i <= options.cells[axis]; ++i)
      coordinates[axis].push_back(options.origin[axis] + options.size[axis] * i / options.cells[axis]);
  check(coordinates, options.removed);
  return lattice_mesh(coordinates, options.removed, options.shape);
}

BaseMesh tensor_mesh(const std::array<std::vector<double>, 3>& coordinates,
                     const std::optional<RemovedBlock>& removed) {
  check(coordinates, removed);
  std::array<int, 3> cells;
  for (int axis = 0; axis < 3; ++axis) cells[axis] = static_cast<int>(coordinates[axis].size()) - 1;
  check_count(cells, CellShape::hexahedron);
  return lattice_mesh(coordinates, removed, CellShape::hexahedron);
}

}  // namespace finegauge
