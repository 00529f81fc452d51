#include "verification/support/refinement_history.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>

namespace finegauge {
namespace {

template <class Visit>
void visit_cells(const RefinementForest& forest, int handle, std::vector<int>& path, const Visit& visit) {
  visit(handle, path);
  const auto cell = forest.cell(handle);
  if (cell.first_child < 0) return;
  for (int child = 0; child < cell.refinement.child_count(); ++child) {
    path.push_back(child);
    visit_cells(forest, cell.first_child + child, path, visit);
    path.pop_back();
  }
}

template <class Visit>
void visit_cells(const RefinementForest& forest, const Visit& visit) {
  for (int base = 0; base < static_cast<int>(forest.base().cells.size()); ++base) {
    std::vector<int> path = {base};
    visit_cells(forest, base, path, visit);
  }
}

int handle_at(const RefinementForest& forest, const std::vector<int>& path) {
  int handle = path[0];
  for (std::size_t level = 1; level < path.size(); ++level) {
    if (forest.is_leaf(handle)) return -1;
    handle = forest.cell(handle).first_child + path[level];
  }
  return handle;
}

}  // namespace

std::vector<RefinementTemplate> all_templates(CellShape shape) {
  if (shape == CellShape::tetrahedron) return {RefinementTemplate{{2, 2, 2}}};
  std::vector<RefinementTemplate> templates;
  for (std::uint8_t n = 1; n <= max_divisions; ++n)
    for (std::uint8_t m = 1; m <= max_divisions; ++m)
      for (std::uint8_t k = 1; k <= max_divisions; ++k)
        if (n * m * k > 1) templates.push_back({{n, m, k}});
  return templates;
}

std::vector<int> leaves(const RefinementForest& forest) {
  std::vector<int> found;
  visit_cells(forest, [&](int handle, const std::vector<int>&) {
    if (forest.is_leaf(handle)) found.push_back(handle);
  });
  return found;
}

std::vector<int> families(const RefinementForest& forest) {
  std::vector<int> found;
  visit_cells(forest, [&](int handle, const std::vector<int>&) {
    if (forest.can_coarsen(handle)) found.push_back(handle);
  });
  return found;
}

int refine_randomly(RefinementForest& forest, const RandomRefinement& options, std::mt19937& generator) {
  int refined = 0;
  for (int k = 0; k < options.refinements; ++k) {
    const auto all = leaves(forest);
    int leaf = all[generator() % all.size()];
    if (const int other = all[generator() % all.size()]; forest.cell(other).depth > forest.cell(leaf).depth)
      leaf = other;
    const RefinementTemplate refinement = options.templates[generator() % options.templates.size()];
    if (forest.cell(leaf).depth >= options.max_depth || !forest.can_refine(leaf, refinement)) continue;
    if (forest.leaf_count() + refinement.child_count() > options.max_leaves) continue;
    forest.refine(leaf, refinement);
    ++refined;
  }
  return refined;
}

void coarsen_randomly(RefinementForest& forest, const std::vector<int>& keep, std::mt19937& generator) {
  for (;;) {
    std::vector<int> all = families(forest);
    std::erase_if(all, [&](int handle) { return std::binary_search(keep.begin(), keep.end(), handle); });
    if (all.empty()) return;
    forest.coarsen(all[generator() % all.size()]);
  }
}

std::vector<RecipeStep> recipe_of(const RefinementForest& forest) {
  std::vector<RecipeStep> recipe;
  visit_cells(forest, [&](int handle, const std::vector<int>& path) {
    if (!forest.is_leaf(handle)) recipe.push_back({path, forest.cell(handle).refinement});
  });
  return recipe;
}

RefinementForest replay(const BaseMesh& base, std::vector<RecipeStep> recipe, std::mt19937& generator) {
  RefinementForest forest(base);
  const auto templates = all_templates(base.shape);
  while (!recipe.empty()) {
    const std::size_t k = generator() % recipe.size();
    const int handle = handle_at(forest, recipe[k].path);
    if (handle < 0) continue;  // its parent comes first
    if (const auto& detour = templates[generator() % templates.size()]; forest.can_refine(handle, detour)) {
      forest.refine(handle, detour);
      forest.coarsen(handle);
    }
    forest.refine(handle, recipe[k].refinement);
    recipe.erase(recipe.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return forest;
}

bool same_bits(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    if (std::memcmp(a.col(j).data(), b.col(j).data(), sizeof(double) * static_cast<std::size_t>(a.rows())) != 0)
      return false;
  return true;
}

bool same_bits(const Mesh& a, const Mesh& b, bool handles) {
  const auto same_face = [](const BoundaryFace& p, const BoundaryFace& q) {
    return p.cell == q.cell && p.face == q.face && p.base == q.base;
  };
  const auto same_frame = [](const LeafFrame& p, const LeafFrame& q) {
    return p.base_cell == q.base_cell && p.depth == q.depth && p.corners == q.corners;
  };
  return a.shape == b.shape && same_bits(a.nodes, b.nodes) && a.cells == b.cells && a.identities == b.identities &&
         a.on_boundary == b.on_boundary && a.fraction == b.fraction && a.means == b.means &&
         std::equal(a.frames.begin(), a.frames.end(), b.frames.begin(), b.frames.end(), same_frame) &&
         std::equal(a.boundary.begin(), a.boundary.end(), b.boundary.begin(), b.boundary.end(), same_face) &&
         (!handles || a.forest_cell == b.forest_cell);
}

}  // namespace finegauge
