#include "core/mesh/region.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/mesh/nested_meshes.hpp"
#include "core/mesh/node_identity.hpp"
#include "core/mesh/point_location.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

/// A unit box of distorted, scrambled cells.
BaseMesh small_scrambled_box(CellShape shape, std::mt19937& generator) {
  BoxMeshOptions box;
  box.cells = shape == CellShape::hexahedron ? std::array{3, 2, 2} : std::array{1, 1, 2};
  box.shape = shape;
  return scrambled(distorted_box(box, 0.15, generator), generator);
}

/// The nodes of some base cells and a face and an edge of others, so that cells, faces, edges and single nodes are
/// held.
std::vector<int> mixed_region(const BaseMesh& base) {
  const int last = static_cast<int>(base.cells.size()) - 1;
  std::set<int> nodes(base.cells[0].begin(), base.cells[0].begin() + corner_count(base.shape));
  for (int c = 0; c < face_corner_count(base.shape); ++c)
    nodes.insert(base.cells[last][face_corners(base.shape, 1)[c]]);
  for (const int corner : edge_corners(base.shape, 2)) nodes.insert(base.cells[last / 2][corner]);
  return {nodes.begin(), nodes.end()};
}

Eigen::Vector3d natural(const LatticePoint& at, CellShape shape) {
  return Eigen::Vector3d(double(at[0]), double(at[1]), double(at[2])) / double(lattice_unit(shape));
}

/// By another road than region_nodes: all base cells around the node, shape functions in doubles.
std::vector<int> held_by_shape_functions(const RefinementForest& forest, const Mesh& mesh,
                                         const std::vector<int>& region) {
  std::vector<int> held;
  std::vector<LocalPoint> points;
  for (int node = 0; node < mesh.node_count(); ++node) {
    local_points(forest.base(), forest.topology(), mesh.identities[node], points);
    std::set<bool> answers;
    for (const auto& [base_cell, at] : points) {
      const Eigen::Vector3d xi = natural(at, mesh.shape);
      const auto N = shape_functions(mesh.shape, xi);
      double outside = 0.0;
      for (int c = 0; c < corner_count(mesh.shape); ++c)
        if (!std::binary_search(region.begin(), region.end(), forest.base().cells[base_cell][c]))
          outside += std::abs(N[c]);
      answers.insert(outside < 1e-9);
    }
    REQUIRE(answers.size() == 1);
    if (*answers.begin()) held.push_back(node);
  }
  return held;
}

std::vector<SupportCondition> hold(const std::string& region) {
  const auto affine = [](const Eigen::Vector3d& X) {
    return Eigen::Vector3d(0.1 + 0.3 * X.y() - X.z(), 0.7 * X.x(), 0.2 - 0.5 * X.x() + 0.4 * X.z());
  };
  return {{region, std::nullopt, affine}};
}

}  // namespace

TEST_CASE("a region holds the nodes where no function of a base node outside of it lives", "[region]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const int seed = GENERATE(1, 2, 3);
  CAPTURE(int(shape), seed);
  std::mt19937 generator(seed);
  BaseMesh base = small_scrambled_box(shape, generator);
  base.regions["held"] = mixed_region(base);
  RefinementForest forest(base);
  const std::vector<int>& region = base.regions.at("held");
  REQUIRE(region_nodes(base, forest.leaf_mesh(), region) == [&] {
    // Before any refinement leaf nodes are base nodes, in another order.
    const Mesh mesh = forest.leaf_mesh();
    std::vector<int> nodes;
    for (int i = 0; i < mesh.node_count(); ++i)
      if (std::binary_search(region.begin(), region.end(), entity_index(mesh.identities[i]))) nodes.push_back(i);
    return nodes;
  }());
  forest.refine(0, {{2, 2, 2}});  // a held cell
  const std::vector<RefinementTemplate> templates = all_templates(shape);
  refine_randomly(forest, {templates, 30, 3, 4000}, generator);
  const Mesh mesh = forest.leaf_mesh();
  const std::vector<int> held = region_nodes(base, mesh, region);
  CHECK(held == held_by_shape_functions(forest, mesh, region));
  std::set<int> dimensions;
  for (const int node : held) dimensions.insert(entity_dimension(mesh.identities[node]));
  CHECK(dimensions.size() >= (shape == CellShape::hexahedron ? 4 : 2));  // vertices, edges, faces, insides
}

TEST_CASE("every template in a held region leaves what is held and what is prescribed as they were",
          "[region][hanging][reversibility]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  std::mt19937 generator(7);
  BaseMesh base = small_scrambled_box(shape, generator);
  base.regions["held"] = mixed_region(base);
  RefinementForest forest(base);
  const int last = static_cast<int>(base.cells.size()) - 1;
  int hanging_held = 0;
  for (const RefinementTemplate& refinement : all_templates(shape)) {
    CAPTURE(to_string(refinement));
    for (const int cell : {0, last / 2, last}) {
      const Discretization before = discretize(forest, {}, hold("held"));
      forest.refine(cell, refinement);
      const Discretization after = discretize(forest, {}, hold("held"));
      // What was held is held, with the same value; and a field that meets the supports before, refined exactly, meets
      // those after.
      Eigen::VectorXd reduced = Eigen::VectorXd::Zero(before.dof_count());
      for (double& value : reduced) value = random_number(generator);
      impose(before.supports, reduced);
      const Eigen::Matrix3Xd u = expand(before.hanging, reduced);
      const std::vector<int> held = region_nodes(base, after.mesh, base.regions.at("held"));
      REQUIRE(held.size() > region_nodes(base, before.mesh, base.regions.at("held")).size() - 1);
      for (const int node : held) {
        const MaterialPoint at = [&] {
          std::vector<LocalPoint> points;
          local_points(base, forest.topology(), after.mesh.identities[node], points);
          return MaterialPoint{points.front().base_cell, natural(points.front().point, shape)};
        }();
        Eigen::Vector3d old_field = Eigen::Vector3d::Zero();
        for (int leaf = 0; leaf < before.mesh.cell_count(); ++leaf)
          if (before.mesh.frames[leaf].base_cell == at.base_cell)
            old_field = interpolate(before.mesh, u, {leaf, at.xi});
        const Eigen::Vector3d affine = hold("held")[0].displacement(after.mesh.nodes.col(node));
        CHECK((old_field - affine).norm() <= 1e-13);
        if (after.hanging.hangs(node)) ++hanging_held;
        for (int k = after.hanging.row_start[node]; k < after.hanging.row_start[node + 1]; ++k)
          CHECK(std::binary_search(after.supports.reduced.begin(), after.supports.reduced.end(),
                                   after.hanging.master[k]));
      }
      forest.coarsen(cell);
      const Discretization again = discretize(forest, {}, hold("held"));
      CHECK(again.supports.reduced == before.supports.reduced);
      CHECK(again.supports.held == before.supports.held);
      CHECK(again.supports.displacement == before.supports.displacement);
      CHECK(same_bits(again.mesh, before.mesh));
    }
  }
  CHECK(hanging_held > 0);
}

TEST_CASE("a hanging node in a region hangs on held nodes alone, whatever was refined around it", "[region][hanging]") {
  // Mixed templates over levels leave bends that two faces share; a region's part must not feel the other's.
  const std::vector<RefinementTemplate> templates = {{{2, 1, 1}}, {{1, 2, 1}}, {{1, 1, 2}}, {{2, 2, 1}},
                                                     {{3, 1, 2}}, {{2, 2, 2}}, {{3, 3, 3}}};
  int hanging_inside = 0;
  for (int seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    std::mt19937 generator(seed);
    BoxMeshOptions box;
    box.cells = {2, 2, 2};
    BaseMesh base = box_mesh(box);
    // The middle node with its six neighbours: edges inside of the body are held, and the faces between them are not.
    std::vector<int>& region = base.regions["held"];
    for (int i = 0; i < base.nodes.cols(); ++i)
      if ((base.nodes.col(i) - Eigen::Vector3d::Constant(0.5)).norm() < 0.6) region.push_back(i);
    REQUIRE(region.size() == 7);
    RefinementForest forest(base);
    refine_randomly(forest, {templates, 25, 3, 3000}, generator);
    const Mesh mesh = forest.leaf_mesh();
    const HangingNodes hanging = find_hanging_nodes(forest, mesh);
    const Supports supports = find_supports(base, mesh, hanging, hold("held"));
    const auto affine = hold("held")[0].displacement;
    for (const int node : region_nodes(base, mesh, region)) {
      if (!hanging.hangs(node)) continue;
      ++hanging_inside;
      Eigen::Vector3d value = Eigen::Vector3d::Zero();
      for (int k = hanging.row_start[node]; k < hanging.row_start[node + 1]; ++k) {
        const auto at = std::ranges::lower_bound(supports.reduced, hanging.master[k]);
        REQUIRE((at != supports.reduced.end() && *at == hanging.master[k]));
        value += hanging.weight[k] * supports.displacement[at - supports.reduced.begin()];
      }
      CHECK((value - affine(mesh.nodes.col(node))).norm() <= 1e-13);
    }
  }
  CHECK(hanging_inside > 100);
}

TEST_CASE("where two edges of a face share one bend, the bend of a held edge is given up", "[region][hanging]") {
  // The face z = 1/2, x, y < 1/2 is halved along x and then, on the right, along y from below; along y and then, at the
  // bottom, along x from above. All that both sides can do is to bend its right edge, inside of the body, and its
  // bottom edge, on the body's surface, by the same amount.
  BoxMeshOptions box;
  box.cells = {2, 2, 2};
  const bool held = GENERATE(false, true);
  CAPTURE(held);
  BaseMesh base = box_mesh(box);
  std::vector<int> region;
  for (int i = 0; i < base.nodes.cols(); ++i)
    if (base.nodes(0, i) == 0.5 && base.nodes(1, i) <= 0.5 && base.nodes(2, i) == 0.5) region.push_back(i);
  REQUIRE(region.size() == 2);
  if (held) base.regions["edge"] = region;
  RefinementForest forest(base);
  forest.refine(0, {{2, 1, 1}});
  forest.refine(forest.cell(0).first_child + 1, {{1, 2, 1}});
  forest.refine(4, {{1, 2, 1}});
  forest.refine(forest.cell(4).first_child, {{2, 1, 1}});
  for (const int beside : {1, 5}) forest.refine(beside, {{1, 2, 1}});  // so that the right edge is halved all around
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  const std::vector<int> nodes = region_nodes(base, mesh, region);
  REQUIRE(nodes.size() == 3);
  bool feels_others = false, hangs = false;
  for (const int node : nodes) {
    hangs = hangs || hanging.hangs(node);
    for (int k = hanging.row_start[node]; k < hanging.row_start[node + 1]; ++k)
      feels_others = feels_others || !std::ranges::binary_search(nodes, hanging.node_of[hanging.master[k]]);
  }
  CHECK(hangs);
  CHECK(feels_others == !held);
}

TEST_CASE("boxes and spheres select base nodes with their edges, and tell how near an empty one is", "[region]") {
  const double unit = GENERATE(1.0, 0x1p-20, 0x1p20);
  CAPTURE(unit);
  BoxMeshOptions box;
  box.size = unit * Eigen::Vector3d(1.0, 1.0, 1.0);
  box.cells = {10, 10, 10};
  const BaseMesh base = box_mesh(box);
  const Eigen::Vector3d low = unit * Eigen::Vector3d(0.1, 0.2, 0.3), high = unit * Eigen::Vector3d(0.3, 0.3, 0.7);
  CHECK(select_nodes(base, BoxSelection{low, high}).numbers.size() == 3 * 2 * 5);  // 0.1 × 3 is above 0.3
  CHECK(select_nodes(base, BoxSelection{low, high}).nearest_outside == 0.0);
  const Selected ball = select_nodes(base, SphereSelection{unit * Eigen::Vector3d::Constant(0.5), unit * 0.1});
  CHECK(ball.numbers.size() == 7);
  CHECK(std::is_sorted(ball.numbers.begin(), ball.numbers.end()));
  const Selected none = select_nodes(base, SphereSelection{unit * Eigen::Vector3d(0.5, 0.5, 1.3), unit * 0.1});
  CHECK(none.numbers.empty());
  CHECK_THAT(none.nearest_outside / unit, WithinAbs(0.2, 1e-14));
  const Selected empty_box =
      select_nodes(base, BoxSelection{unit * Eigen::Vector3d(1.3, 1.4, 0.5), unit * Eigen::Vector3d(2.0, 2.0, 0.5)});
  CHECK(empty_box.numbers.empty());
  CHECK_THAT(empty_box.nearest_outside / unit, WithinAbs(0.5, 1e-14));
  // A patch of a box's face: the nodes of the faces whose centre is near the surface's point below (0.5, 0.5, 2).
  const Selected patch = select_nodes(base, PatchSelection{unit * Eigen::Vector3d(0.55, 0.55, 2.0), unit * 0.1});
  CHECK(patch.numbers.size() == 12);
  for (const int node : patch.numbers) CHECK(base.nodes(2, node) == unit);
}

TEST_CASE("a region must name existing nodes in order, and not a surface", "[region]") {
  BoxMeshOptions box;
  BaseMesh base = box_mesh(box);
  base.regions["held"] = {0, 3, 7};
  CHECK(validate(base).empty());
  base.regions["held"] = {0, 3, 8};
  CHECK(validate(base) == "region 'held': node 8 does not exist");
  base.regions["held"] = {0, 3, 3};
  CHECK(validate(base) == "region 'held': node 3 is out of order: nodes must ascend");
  base.regions["held"] = {};
  CHECK(validate(base).empty());
  base.regions["x_min"] = {1};
  CHECK(validate(base) == "region 'x_min' has the name of a surface");
}
