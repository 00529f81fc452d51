#include "core/mesh/immersed_body.hpp"
#include "core/mesh/material_share.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

namespace {

/// What is wrong with a cell's share of material.
std::string bad_share(const RefinementForest& forest, int handle) {
  const auto& cell = forest.cell(handle);
  const ImmersedBody* body = forest.base().body.get();
  if (!body) return cell.share == 1.0 ? "" : " is not full, but nothing is immersed";
  if (!(cell.share >= 0.0 && cell.share <= 1.0)) return " has a share of material outside 0 to 1";
  const double parent = cell.parent < 0 ? -1.0 : forest.cell(cell.parent).share;
  const bool inherited = parent == 0.0 || parent == 1.0;
  if (cell.share != (inherited ? parent : material_share(*body, hexahedron_frame(forest, handle))))
    return " does not have the share of material that lies in it";
  if (cell.means != material_means(*body, hexahedron_frame(forest, handle), cell.share))
    return " does not have its material where that lies";
  return {};
}

}  // namespace

std::string validate(const RefinementForest& forest) {
  std::vector<int> seen(forest.handle_count(), 0);
  std::vector<int> open;
  int leaves = 0;
  for (int cell = 0; cell < static_cast<int>(forest.base().cells.size()); ++cell) open.push_back(cell);
  while (!open.empty()) {
    const int handle = open.back();
    open.pop_back();
    const auto& cell = forest.cell(handle);
    const std::string name = "cell " + std::to_string(handle);
    if (seen[handle]++) return name + " is reached twice";
    if (const std::string fault = bad_share(forest, handle); !fault.empty()) return name + fault;
    if (cell.first_child < 0) {
      ++leaves;
      continue;
    }
    for (int child = cell.first_child; child < cell.first_child + cell.refinement.child_count(); ++child) {
      const auto& young = forest.cell(child);
      if (young.parent != handle) return name + " is not the parent of its child " + std::to_string(child);
      if (young.base != cell.base || young.depth != cell.depth + 1) return name + " has a child of another tree";
      for (int axis = 0; axis < 3; ++axis)
        if (young.per_edge[axis] != cell.per_edge[axis] * cell.refinement.divisions[axis])
          return name + " has a child of the wrong size";
      open.push_back(child);
    }
  }
  if (leaves != forest.leaf_count()) return "the count of leaves is wrong";
  return {};
}

}  // namespace finegauge
