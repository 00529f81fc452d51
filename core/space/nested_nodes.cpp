#include "core/space/nested_nodes.hpp"

#include "core/mesh/nested_meshes.hpp"

namespace finegauge {

std::vector<OldNode> find_old_nodes(const Mesh& from, const Mesh& to) {
  std::vector<OldNode> old(from.node_count());
  const int corners = corner_count(from.shape);
  visit_nested_leaves(from, to, [&](int old_cell, int new_cell) {
    const LeafFrame &old_leaf = from.frames[old_cell], &new_leaf = to.frames[new_cell];
    for (int a = 0; a < corners; ++a) {
      OldNode& place = old[from.cells[old_cell][a]];
      if (place.node >= 0) continue;
      const LatticePoint point = lattice_corner(from.shape, old_leaf, a);
      for (int c = 0; c < corners && place.node < 0; ++c)
        if (lattice_corner(to.shape, new_leaf, c) == point) place.node = to.cells[new_cell][c];
      if (place.node < 0 && place.cell < 0 && new_leaf.depth < old_leaf.depth)
        place = {-1, new_cell, natural_coordinates(to.shape, new_leaf, point)};
    }
  });
  return old;
}

}  // namespace finegauge
