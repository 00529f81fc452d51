#include "verification/support/tetrahedra_of.hpp"

#include <algorithm>
#include <stdexcept>

namespace finegauge {

namespace {

/// The two triangles of a face, by the tetrahedra of its cell.
void add_triangles(const BaseFace& face, std::vector<BaseFace>& triangles) {
  const auto& quadrilateral = hexahedron_faces[face.face];
  const auto on_face = [&](int corner) { return std::ranges::find(quadrilateral, corner) != quadrilateral.end(); };
  for (int path = 0; path < 6; ++path)
    for (int triangle = 0; triangle < 4; ++triangle) {
      const auto& corners = tetrahedron_faces[triangle];
      const auto& of = kuhn_tetrahedra[path];
      if (on_face(of[corners[0]]) && on_face(of[corners[1]]) && on_face(of[corners[2]]))
        triangles.push_back({6 * face.cell + path, triangle});
    }
}

}  // namespace

BaseMesh tetrahedra_of(const BaseMesh& hexahedra) {
  BaseMesh mesh;
  mesh.shape = CellShape::tetrahedron;
  mesh.nodes = hexahedra.nodes;
  mesh.regions = hexahedra.regions;
  for (const auto& corners : hexahedra.cells)
    for (const auto& path : kuhn_tetrahedra) {
      auto& cell = mesh.cells.emplace_back();
      cell.fill(-1);
      for (int k = 0; k < 4; ++k) cell[k] = corners[path[k]];
    }
  for (const auto& [name, faces] : hexahedra.surfaces) {
    std::vector<BaseFace>& triangles = mesh.surfaces[name];
    for (const BaseFace& face : faces) add_triangles(face, triangles);
    std::ranges::sort(triangles);
  }
  if (boundary_faces(mesh).size() != 2 * boundary_faces(hexahedra).size())
    throw std::invalid_argument("tetrahedra_of: neighbours cut a face along different diagonals");
  return mesh;
}

}  // namespace finegauge
