#include "core/mesh/refinement_forest.hpp"

#include "core/equilibrium.hpp"
#include "core/space/transfer.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

BaseMesh scrambled_box(CellShape shape, std::mt19937& generator) {
  BoxMeshOptions options;
  options.cells = shape == CellShape::hexahedron ? std::array{3, 2, 2} : std::array{2, 1, 1};
  options.size = {1.5, 1.0, 0.8};
  options.shape = shape;
  return scrambled(distorted_box(options, 0.1, generator), generator);
}

std::vector<int> refined_handles(const RefinementForest& forest) {
  std::vector<int> handles;
  for (const int leaf : leaves(forest))
    for (int parent = forest.cell(leaf).parent; parent >= 0; parent = forest.cell(parent).parent)
      handles.push_back(parent);
  std::sort(handles.begin(), handles.end());
  handles.erase(std::unique(handles.begin(), handles.end()), handles.end());
  return handles;
}

Material corotational() {
  Material material;
  material.dilatation = Dilatation::mean;
  material.kinematics = Kinematics::corotational;
  return material;
}

const std::vector<SupportCondition> clamped_front = {{"x_min", {}, {}}};
const std::vector<SurfaceLoad> sideways_total = {{"x_max", LoadKind::total_by_area, {0.5, 1.0, -2.0}}};

/// All that is computed from a forest, down to the solution from a given start.
struct Everything {
  Discretization d;
  Eigen::VectorXd stiffness;
  Eigen::Matrix3Xd loads, u;
};
Everything compute(const RefinementForest& forest, const Material& material, const Eigen::Matrix3Xd* start) {
  Everything all{discretize(forest, material, clamped_front), {}, {}, {}};
  const Eigen::Matrix3Xd from = start ? *start : Eigen::Matrix3Xd::Zero(3, all.d.mesh.node_count());
  const auto A = assemble_stiffness(all.d, from);
  all.stiffness = Eigen::Map<const Eigen::VectorXd>(A.values.data(), static_cast<Eigen::Index>(A.values.size()));
  all.loads = nodal_loads(forest.base(), all.d.mesh, sideways_total);
  const MeshHierarchy hierarchy = build_hierarchy(forest, all.d, clamped_front, {20, 0.9});
  EquilibriumOptions options;
  options.newton_iterations = 3;  // far from converged: the bits along the way count
  options.method = LinearMethod::multigrid;
  all.u = solve_equilibrium(all.d, hierarchy, all.loads, from, options).u;
  return all;
}

}  // namespace

TEST_CASE("random refinements undone in random order leave every bit as it was", "[forest][reversibility]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u, 3u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  RefinementForest forest(scrambled_box(shape, generator));
  const auto templates = all_templates(shape);
  // The start is a refined mesh itself, nested and with hanging nodes.
  REQUIRE(refine_randomly(forest, {templates, 6, 3, 250}, generator) > 2);
  const std::vector<int> kept = refined_handles(forest);
  const Everything before = compute(forest, corotational(), nullptr);
  REQUIRE(before.d.hanging.hanging_count() > 0);
  int deepest = 0;
  for (int cycle = 0; cycle < 5; ++cycle) {
    REQUIRE(refine_randomly(forest, {templates, 60, 6, 3000}, generator) > 5);
    for (const int leaf : leaves(forest)) deepest = std::max(deepest, forest.cell(leaf).depth);
    REQUIRE(validate(forest).empty());
    coarsen_randomly(forest, kept, generator);
    REQUIRE(validate(forest).empty());
  }
  CHECK(deepest >= 4);
  const Everything after = compute(forest, corotational(), nullptr);
  CHECK(same_bits(before.d.mesh, after.d.mesh, true));
  CHECK(before.d.hanging.row_start == after.d.hanging.row_start);
  CHECK(before.d.hanging.master == after.d.hanging.master);
  CHECK(before.d.hanging.weight == after.d.hanging.weight);
  CHECK(before.d.hanging.node_of == after.d.hanging.node_of);
  CHECK(before.d.pattern.column == after.d.pattern.column);
  CHECK(before.d.supports.reduced == after.d.supports.reduced);
  CHECK(same_bits(before.stiffness, after.stiffness));
  CHECK(same_bits(before.loads, after.loads));
  CHECK(same_bits(before.u, after.u));
  CHECK(before.u.norm() > 1e-3);
}

TEST_CASE("ten thousand random refinements and coarsenings do not grow the storage", "[forest][reversibility]") {
  std::mt19937 generator(4);
  RefinementForest forest(scrambled_box(CellShape::hexahedron, generator));
  const Mesh start = forest.leaf_mesh();
  const auto templates = all_templates();
  // The largest state that the cycles visit: every base cell in 64, and one nested family of every template at once.
  const auto cycle = [&] {
    const int cell = static_cast<int>(generator() % forest.base().cells.size());
    const auto& outer = templates[generator() % templates.size()];
    forest.refine(cell, outer);
    const int child = forest.cell(cell).first_child + static_cast<int>(generator() % outer.child_count());
    forest.refine(child, templates[generator() % templates.size()]);
    coarsen_randomly(forest, {}, generator);
  };
  // A cycle holds two families at once; two of each size are all that can ever be in use.
  for (const auto& refinement : templates) {
    forest.refine(0, refinement);
    forest.refine(forest.cell(0).first_child, refinement);
    coarsen_randomly(forest, {}, generator);
  }
  for (int k = 0; k < 100; ++k) cycle();
  const std::size_t bytes = forest.storage_bytes();
  for (int k = 0; k < 10000; ++k) cycle();
  CHECK(forest.storage_bytes() == bytes);
  CHECK(validate(forest).empty());
  CHECK(forest.leaf_count() == static_cast<int>(forest.base().cells.size()));
  CHECK(same_bits(start, forest.leaf_mesh(), true));
}

TEST_CASE("the mesh does not depend on the order of refinement", "[forest]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(5u, 6u, 7u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  const BaseMesh base = scrambled_box(shape, generator);
  RefinementForest forest(base);
  const auto templates = all_templates(shape);
  REQUIRE(refine_randomly(forest, {templates, 25, 5, 2000}, generator) >= 10);
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  REQUIRE(hanging.hanging_count() > 0);
  bool handles_differ = false;
  for (int k = 0; k < 4; ++k) {
    const RefinementForest other = replay(base, recipe_of(forest), generator);
    REQUIRE(validate(other).empty());
    const Mesh other_mesh = other.leaf_mesh();
    handles_differ = handles_differ || mesh.forest_cell != other_mesh.forest_cell;
    CHECK(same_bits(mesh, other_mesh));
    const HangingNodes other_hanging = find_hanging_nodes(other, other_mesh);
    CHECK(hanging.master == other_hanging.master);
    CHECK(hanging.weight == other_hanging.weight);
  }
  CHECK(handles_differ);  // otherwise the orders were the same
}

TEST_CASE("the shares of the leaves of a base cell sum to one", "[forest]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  std::mt19937 generator(12);
  RefinementForest forest(scrambled_box(shape, generator));
  const auto templates = all_templates(shape);
  refine_randomly(forest, {templates, 20, 4, 2000}, generator);
  const Mesh mesh = forest.leaf_mesh();
  std::vector<double> sum(forest.base().cells.size(), 0.0);
  double smallest = 1.0;
  for (const int handle : mesh.forest_cell) {
    const double share = share_of_base_cell(forest.cell(handle));
    sum[forest.cell(handle).base] += share;
    smallest = std::min(smallest, share);
  }
  for (const double total : sum) CHECK_THAT(total, WithinAbs(1.0, 1e-12));
  CHECK(smallest < 0.01);
}

TEST_CASE("meshes of every height are the same with the heights at hand", "[forest]") {
  std::mt19937 generator(13);
  RefinementForest forest(scrambled_box(CellShape::hexahedron, generator));
  const auto templates = all_templates(CellShape::hexahedron);
  refine_randomly(forest, {templates, 10, 3, 1000}, generator);
  const std::vector<int> heights = forest.heights();
  for (int height = 0; height < 4; ++height)
    CHECK(same_bits(forest.leaf_mesh(height), forest.leaf_mesh(height, heights), true));
}

TEST_CASE("leaves fill the body whatever the corner order of neighbouring base cells", "[forest]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  std::mt19937 generator(8);
  RefinementForest forest(scrambled_box(shape, generator));
  const auto templates = all_templates(shape);
  refine_randomly(forest, {templates, 20, 4, 2000}, generator);
  const Mesh mesh = forest.leaf_mesh();
  double volume = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    volume += cell_geometry(shape, corner_values(mesh, cell, mesh.nodes)).volume;
  CHECK_THAT(volume, WithinRel(1.5 * 1.0 * 0.8, 1e-13));
  // Boundary faces, by surface: together as large as the box's sides.
  const auto total = [&](const char* surface) {
    return nodal_loads(forest.base(), mesh, {{surface, LoadKind::traction, {1.0, 0.0, 0.0}}}).row(0).sum();
  };
  CHECK_THAT(total("x_min"), WithinRel(0.8, 1e-13));
  CHECK_THAT(total("x_max"), WithinRel(0.8, 1e-13));
  CHECK_THAT(total("y_max"), WithinRel(1.2, 1e-13));
  CHECK_THAT(total("z_min"), WithinRel(1.5, 1e-13));
}

TEST_CASE("nodes of neighbouring base cells with different corner orders are one node", "[forest]") {
  // All refined 2x2x2 twice: a conforming mesh whose node count is known.
  std::mt19937 generator(9);
  BoxMeshOptions options;
  options.cells = {3, 2, 2};
  RefinementForest forest(scrambled(box_mesh(options), generator));
  for (int level = 0; level < 2; ++level)
    for (const int leaf : leaves(forest)) forest.refine(leaf, {{2, 2, 2}});
  const Mesh mesh = forest.leaf_mesh();
  CHECK(mesh.node_count() == 13 * 9 * 9);
  CHECK(find_hanging_nodes(forest, mesh).hanging_count() == 0);
  CHECK(forest.leaf_mesh(1).node_count() == 7 * 5 * 5);
  CHECK(forest.leaf_mesh(2).node_count() == 4 * 3 * 3);
}

TEST_CASE("refinement stops where the lattice ends", "[forest]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  BoxMeshOptions options;
  options.shape = shape;
  RefinementForest forest(box_mesh(options));
  int leaf = 0, depth = 0;
  while (forest.can_refine(leaf, {{2, 2, 2}})) {
    forest.refine(leaf, {{2, 2, 2}});
    leaf = forest.cell(leaf).first_child;
    ++depth;
  }
  CHECK(depth == (shape == CellShape::hexahedron ? 30 : 39));
  CHECK(validate(forest).empty());
  if (shape == CellShape::hexahedron) {
    CHECK(forest.can_refine(leaf, {{3, 3, 3}}));
    CHECK_FALSE(forest.can_refine(leaf, {{4, 1, 1}}));
  }
  CHECK_FALSE(forest.can_refine(0, {{2, 2, 2}}));  // not a leaf
}

TEST_CASE("a cell outside the templates is refused", "[forest]") {
  RefinementForest hexahedron(box_mesh({}));
  CHECK_FALSE(hexahedron.can_refine(0, {{1, 1, 1}}));
  CHECK_FALSE(hexahedron.can_refine(0, {{5, 1, 1}}));
  CHECK(hexahedron.can_refine(0, {{1, 1, 4}}));
  BoxMeshOptions options;
  options.shape = CellShape::tetrahedron;
  const RefinementForest tetrahedron(box_mesh(options));
  CHECK(tetrahedron.can_refine(0, {{2, 2, 2}}));
  CHECK_FALSE(tetrahedron.can_refine(0, {{3, 3, 3}}));
  CHECK_FALSE(tetrahedron.can_refine(0, {{2, 1, 1}}));
}

TEST_CASE("templates are written n x m x k", "[forest]") {
  for (const auto& refinement : all_templates()) CHECK(parse_refinement_template(to_string(refinement)) == refinement);
  for (const char* wrong : {"1x1x1", "5x1x1", "0x2x2", "2x2", "2x2x2x", "2,2,2", ""})
    CHECK_THROWS_AS(parse_refinement_template(wrong), std::invalid_argument);
}
