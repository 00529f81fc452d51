#include "core/adapt/apply_refinements.hpp"

namespace finegauge {

int apply_refinements(RefinementForest& forest, const Mesh& mesh, const std::vector<Refinement>& refinements) {
  int refined = 0;
  for (const auto& [cell, refinement] : refinements) {
    const int leaf = mesh.forest_cell[cell];
    if (!forest.can_refine(leaf, refinement)) continue;
    ++refined;
    RefinementTemplate outer = refinement, inner{{1, 1, 1}};
    for (int axis = 0; axis < 3; ++axis)
      if (refinement.divisions[axis] == 4) outer.divisions[axis] = inner.divisions[axis] = 2;
    forest.refine(leaf, outer);
    if (inner.child_count() == 1) continue;
    const int first = forest.cell(leaf).first_child;
    for (int child = first; child < first + outer.child_count(); ++child) forest.refine(child, inner);
  }
  return refined;
}

void refine_uniformly(RefinementForest& forest, RefinementTemplate refinement) {
  const Mesh mesh = forest.leaf_mesh();
  for (const int leaf : mesh.forest_cell) forest.refine(leaf, refinement);
}

}  // namespace finegauge
