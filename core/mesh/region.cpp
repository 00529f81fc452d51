#include "core/mesh/region.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/mesh/nested_meshes.hpp"
#include "core/mesh/selection_distance.hpp"
#include "core/mesh/surface_selection.hpp"

namespace finegauge {
namespace {

/// Whether base corner c's shape function is not zero at a lattice point of the base cell.
bool reaches(CellShape shape, int c, const LatticePoint& at) {
  const std::uint64_t unit = lattice_unit(shape);
  if (shape == CellShape::tetrahedron) return c == 0 ? at[0] + at[1] + at[2] != unit : at[c - 1] != 0;
  for (int axis = 0; axis < 3; ++axis)
    if (at[axis] == ((c >> axis) & 1 ? 0 : unit)) return false;
  return true;
}

std::vector<int> sorted_once(std::vector<int> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

Selected patch_nodes(const BaseMesh& base, const PatchSelection& patch) {
  const std::vector<SurfaceFacet> facets = surface_facets(base);
  Selected chosen = select_facets(facets, patch);
  std::vector<int> nodes;
  if (base.body) {
    for (const int cell : touched_cells(base, facets, chosen.numbers))
      nodes.insert(nodes.end(), base.cells[cell].begin(), base.cells[cell].begin() + corner_count(base.shape));
  } else {
    for (const int facet : chosen.numbers)
      for (int c = 0; c < facets[facet].corner_count; ++c)
        nodes.push_back(base.cells[facets[facet].face.cell][face_corners(base.shape, facets[facet].face.face)[c]]);
  }
  chosen.numbers = sorted_once(std::move(nodes));
  return chosen;
}

}  // namespace

Selected select_nodes(const BaseMesh& base, const Selection& selection) {
  if (const auto* patch = std::get_if<PatchSelection>(&selection)) return patch_nodes(base, *patch);
  return select_points(base.nodes, selection, selection_slack(base.nodes));
}

std::vector<int> region_nodes(const BaseMesh& base, const Mesh& mesh, const std::vector<int>& region) {
  std::vector<std::uint8_t> inside(static_cast<std::size_t>(base.nodes.cols()), 0);
  for (const int node : region) inside[node] = 1;
  const int corners = corner_count(mesh.shape);
  std::vector<int> nodes;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const auto& base_nodes = base.cells[mesh.frames[cell].base_cell];
    if (std::none_of(base_nodes.begin(), base_nodes.begin() + corners, [&](int node) { return inside[node] != 0; }))
      continue;
    for (int c = 0; c < corners; ++c) {
      const LatticePoint at = lattice_corner(mesh.shape, mesh.frames[cell], c);
      bool held = true;
      for (int b = 0; b < corners && held; ++b) held = inside[base_nodes[b]] != 0 || !reaches(mesh.shape, b, at);
      if (held) nodes.push_back(mesh.cells[cell][c]);
    }
  }
  return sorted_once(std::move(nodes));
}

}  // namespace finegauge
