#pragma once

#include <random>
#include <span>
#include <vector>

#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

/// All templates of hexahedra, n × m × k up to 4 and not all 1: 63 of them. Tetrahedra have 2x2x2 only.
std::vector<RefinementTemplate> all_templates(CellShape shape = CellShape::hexahedron);

/// Handles of the leaves, in the order of the mesh; of the cells whose children are all leaves.
std::vector<int> leaves(const RefinementForest& forest);
std::vector<int> families(const RefinementForest& forest);

struct RandomRefinement {
  std::span<const RefinementTemplate> templates;
  int refinements = 10;
  int max_depth = 4;
  int max_leaves = 3000;
};
/// Refines random leaves by random templates, deep leaves rather than shallow ones. Returns how many it refined.
int refine_randomly(RefinementForest& forest, const RandomRefinement& options, std::mt19937& generator);
/// Coarsens random families whose cells are not in `keep` (handles, ascending), until none is left.
void coarsen_randomly(RefinementForest& forest, const std::vector<int>& keep, std::mt19937& generator);

/// A refined cell by its place: the base cell, then the child's number at each level.
struct RecipeStep {
  std::vector<int> path;
  RefinementTemplate refinement;
};
/// Everything that was refined in the forest, parents first.
std::vector<RecipeStep> recipe_of(const RefinementForest& forest);
/// The same refinements on a fresh forest in a random order, with detours: leaves refined and coarsened in between.
RefinementForest replay(const BaseMesh& base, std::vector<RecipeStep> recipe, std::mt19937& generator);

/// Whether all that a mesh says is the same, bit by bit; handles in the forest only where asked.
bool same_bits(const Mesh& a, const Mesh& b, bool handles = false);
bool same_bits(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b);

}  // namespace finegauge
