#include "core/mesh/nested_meshes.hpp"

#include <map>
#include <set>
#include <stdexcept>

#include "core/mesh/refinement_forest.hpp"
#include "core/space/assembly.hpp"
#include "core/space/transfer.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

/// Whether the centre of one leaf lies in another of the same base cell; parallelepipeds and tetrahedra.
bool holds(const Mesh& mesh, int cell, const Mesh& other, int other_cell) {
  LatticePoint sum{};
  const int corners = corner_count(other.shape);
  for (int c = 0; c < corners; ++c)
    for (int axis = 0; axis < 3; ++axis)
      sum[axis] += lattice_corner(other.shape, other.frames[other_cell], c)[axis] / static_cast<unsigned>(corners);
  const Eigen::Vector3d xi = natural_coordinates(mesh.shape, mesh.frames[cell], sum);
  const double highest = mesh.shape == CellShape::hexahedron ? xi.maxCoeff() : xi.sum();
  return xi.minCoeff() > 0.0 && highest < 1.0;
}

}  // namespace

TEST_CASE("all pairs of nested leaves are visited once, and no other pair", "[nested]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u, 3u, 4u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  BoxMeshOptions options;
  options.cells = {2, 1, 1};
  options.shape = shape;
  RefinementForest forest(scrambled(box_mesh(options), generator));
  const auto templates = all_templates(shape);
  REQUIRE(refine_randomly(forest, {templates, 8, 3, 150}, generator) > 2);
  const Mesh first = forest.leaf_mesh();
  // Some families go, some leaves are refined: each leaf is the same, a parent or a child of one before.
  const auto old_families = families(forest);
  const auto old_leaves = leaves(forest);
  for (const int family : old_families)
    if (generator() % 2) forest.coarsen(family);
  int refined = 0;
  for (const int leaf : old_leaves) {
    const int parent = forest.cell(leaf).parent;
    if ((parent >= 0 && forest.is_leaf(parent)) || generator() % 4) continue;
    forest.refine(leaf, templates[generator() % templates.size()]);
    ++refined;
  }
  REQUIRE(refined > 0);
  const Mesh second = forest.leaf_mesh();

  std::map<std::pair<int, int>, int> visited;
  visit_nested_leaves(first, second, [&](int a, int b) { ++visited[{a, b}]; });
  std::set<std::pair<int, int>> nested;
  for (int a = 0; a < first.cell_count(); ++a)
    for (int b = 0; b < second.cell_count(); ++b)
      if (first.frames[a].base_cell == second.frames[b].base_cell &&
          (holds(first, a, second, b) || holds(second, b, first, a)))
        nested.insert({a, b});
  for (const auto& [pair, count] : visited) {
    CHECK(count == 1);
    CHECK(nested.count(pair) == 1);
  }
  CHECK(visited.size() == nested.size());
}

TEST_CASE("natural coordinates of a leaf's own corners are the reference corners", "[nested]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  std::mt19937 generator(5);
  BoxMeshOptions options;
  options.shape = shape;
  RefinementForest forest(box_mesh(options));
  const auto templates = all_templates(shape);
  refine_randomly(forest, {templates, 20, 5, 500}, generator);
  const Mesh mesh = forest.leaf_mesh();
  double error = 0.0, position_error = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int c = 0; c < corner_count(shape); ++c) {
      const LatticePoint point = lattice_corner(shape, mesh.frames[cell], c);
      const auto N = shape_functions(shape, natural_coordinates(shape, mesh.frames[cell], point));
      for (int a = 0; a < corner_count(shape); ++a) error = std::max(error, std::abs(N[a] - (a == c ? 1.0 : 0.0)));
      // And the base cell's interpolation at the lattice point is the node's position.
      const auto N_base =
          shape_functions(shape, natural_coordinates(shape, base_frame(shape, mesh.frames[cell].base_cell), point));
      Eigen::Vector3d x = -mesh.nodes.col(mesh.cells[cell][c]);
      for (int a = 0; a < corner_count(shape); ++a)
        x += N_base[a] * forest.base().nodes.col(forest.base().cells[mesh.frames[cell].base_cell][a]);
      position_error = std::max(position_error, x.norm());
    }
  CHECK_THAT(error, WithinAbs(0.0, 1e-13));
  CHECK_THAT(position_error, WithinAbs(0.0, 1e-14));
}

TEST_CASE("leaves are paired rightly however deep one corner is refined", "[nested][depth]") {
  // Ten halvings make a leaf a billionth of its base cell: a sum of shares would lose it.
  const RefinementTemplate refinement =
      GENERATE(RefinementTemplate{{2, 2, 2}}, RefinementTemplate{{3, 3, 3}}, RefinementTemplate{{4, 4, 4}});
  CAPTURE(to_string(refinement));
  BoxMeshOptions options;
  options.cells = {2, 2, 2};
  RefinementForest forest(box_mesh(options));
  const Mesh coarse = forest.leaf_mesh();
  int leaf = 7;
  for (int level = 0; level < 14 && forest.can_refine(leaf, refinement); ++level) {
    forest.refine(leaf, refinement);
    leaf = forest.cell(leaf).first_child + refinement.child_count() - 1;
  }
  const Mesh fine = forest.leaf_mesh();
  REQUIRE(forest.cell(leaf).depth >= 12);
  const Eigen::Matrix3Xd linear = 2.0 * coarse.nodes.array() + 1.0;
  const Eigen::Matrix3Xd carried = transfer(coarse, linear, fine);
  CHECK((carried.array() - (2.0 * fine.nodes.array() + 1.0)).abs().maxCoeff() < 1e-14);
  CHECK((transfer(fine, carried, coarse) - linear).cwiseAbs().maxCoeff() == 0.0);
}

TEST_CASE("a change of template in one step is refused", "[nested]") {
  BoxMeshOptions options;
  RefinementForest halves(box_mesh(options)), thirds(box_mesh(options));
  halves.refine(0, {{2, 2, 2}});
  thirds.refine(0, {{3, 3, 3}});
  CHECK_THROWS_AS(visit_nested_leaves(halves.leaf_mesh(), thirds.leaf_mesh(), [](int, int) {}), std::logic_error);
}
