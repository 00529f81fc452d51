#include "core/mesh/hanging_nodes.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <numeric>

#include "core/mesh/nested_meshes.hpp"
#include "core/mesh/node_identity.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/conformity.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

BaseMesh box(std::array<int, 3> cells, CellShape shape = CellShape::hexahedron) {
  BoxMeshOptions options;
  options.cells = cells;
  options.shape = shape;
  return box_mesh(options);
}

/// Planes of the unit box that a position is on, as bits. Other nodes are 4^-5 away from them at least.
int planes_of(const Eigen::Vector3d& x) {
  int planes = 0;
  for (int axis = 0; axis < 3; ++axis)
    planes |= (x[axis] < 1e-12) << (2 * axis) | (x[axis] > 1.0 - 1e-12) << (2 * axis + 1);
  return planes;
}

/// What has to hold of T on every mesh of the unit box.
void check_interpolation(const RefinementForest& forest, const Mesh& mesh, const HangingNodes& hanging) {
  REQUIRE(hanging.row_start.size() == static_cast<std::size_t>(mesh.node_count()) + 1);
  double sum_error = 0.0, linear_error = 0.0;
  int leaving_planes = 0;
  for (int node = 0; node < mesh.node_count(); ++node) {
    double sum = -1.0;
    Eigen::Vector3d linear = -mesh.nodes.col(node);
    const int first = hanging.row_start[node], last = hanging.row_start[node + 1];
    if (!hanging.hangs(node)) {
      REQUIRE(last == first + 1);
      REQUIRE(hanging.master[first] == hanging.reduced_of[node]);
      REQUIRE(hanging.weight[first] == 1.0);
    }
    for (int k = first; k < last; ++k) {
      if (k > first) REQUIRE(hanging.master[k] > hanging.master[k - 1]);
      REQUIRE(hanging.master[k] >= 0);
      const int master = hanging.node_of[hanging.master[k]];
      REQUIRE(hanging.reduced_of[master] == hanging.master[k]);
      sum += hanging.weight[k];
      linear += hanging.weight[k] * mesh.nodes.col(master);
      const int planes = planes_of(mesh.nodes.col(node));
      leaving_planes += (planes_of(mesh.nodes.col(master)) & planes) != planes;
    }
    sum_error = std::max(sum_error, std::abs(sum));
    linear_error = std::max(linear_error, linear.cwiseAbs().maxCoeff());
  }
  // Round-off of some dozens of terms; weights of a few units in size.
  CHECK_THAT(sum_error, WithinAbs(0.0, 1e-12));
  CHECK_THAT(linear_error, WithinAbs(0.0, 1e-12));
  CHECK(leaving_planes == 0);  // a boundary node's masters are on the same planes
  std::mt19937 generator(17);
  Eigen::VectorXd reduced(3 * hanging.reduced_count());
  for (double& value : reduced) value = random_number(generator);
  const Eigen::Matrix3Xd nodal = expand(hanging, reduced);
  CHECK(gather(hanging, nodal) == reduced);
  CHECK_THAT(largest_jump(forest, mesh, nodal, 12, 23), WithinAbs(0.0, 1e-11));
}

/// The oracle: all demands of all leaves on all nodes in them, densely, from positions in lattice units alone.
Eigen::MatrixXd all_equations(const RefinementForest& forest, const Mesh& mesh) {
  std::vector<Eigen::VectorXd> rows;
  std::vector<LocalPoint> points;
  for (int node = 0; node < mesh.node_count(); ++node) {
    local_points(forest.base(), forest.topology(), mesh.identities[node], points);
    for (const auto& [base_cell, point] : points)
      for (int cell = 0; cell < mesh.cell_count(); ++cell) {
        if (mesh.frames[cell].base_cell != base_cell) continue;
        if (std::count(mesh.cells[cell].begin(), mesh.cells[cell].end(), node)) continue;
        const Eigen::Vector3d xi = natural_coordinates(mesh.shape, mesh.frames[cell], point);
        const double highest = mesh.shape == CellShape::hexahedron ? xi.maxCoeff() : xi.sum();
        if (xi.minCoeff() < -1e-12 || highest > 1.0 + 1e-12) continue;
        const auto N = shape_functions(mesh.shape, xi);
        Eigen::VectorXd row = Eigen::VectorXd::Zero(mesh.node_count());
        row[node] = -1.0;
        for (int c = 0; c < corner_count(mesh.shape); ++c) row[mesh.cells[cell][c]] += N[c];
        rows.push_back(row);
      }
  }
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(std::max<Eigen::Index>(1, rows.size()), mesh.node_count());
  for (std::size_t k = 0; k < rows.size(); ++k) equations.row(static_cast<Eigen::Index>(k)) = rows[k];
  return equations;
}

struct Dimension {
  int reduced, nullity, hanging;
  double residual;  // of the equations on the range of T
};
Dimension dimension(const RefinementForest& forest) {
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  const Eigen::MatrixXd equations = all_equations(forest, mesh);
  const Eigen::VectorXd singular = Eigen::JacobiSVD<Eigen::MatrixXd>(equations).singularValues();
  const int rank = static_cast<int>((singular.array() > 1e-9).count());
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(mesh.node_count(), hanging.reduced_count());
  for (int node = 0; node < mesh.node_count(); ++node)
    for (int k = hanging.row_start[node]; k < hanging.row_start[node + 1]; ++k)
      T(node, hanging.master[k]) = hanging.weight[k];
  return {hanging.reduced_count(), mesh.node_count() - rank, hanging.hanging_count(),
          (equations * T).cwiseAbs().maxCoeff()};
}

}  // namespace

TEST_CASE("every template beside every other one leaves a conforming interpolation", "[hanging]") {
  const auto templates = all_templates();
  const auto k = GENERATE(range(0, 63));
  RefinementForest forest(box({2, 2, 1}));
  forest.refine(0, templates[k]);
  forest.refine(1, templates[(7 * k + 11) % templates.size()]);
  forest.refine(2, templates[(13 * k + 5) % templates.size()]);
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  CHECK(hanging.hanging_count() > 0);
  check_interpolation(forest, mesh, hanging);
}

TEST_CASE("random nested refinements of scrambled base cells are conforming", "[hanging]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  // In the last one the leaves alone would couple two faces of the body, found among 500 seeds.
  const auto seed = GENERATE(range(1u, 13u), value(1218u));
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  BoxMeshOptions options;
  options.cells = shape == CellShape::hexahedron ? std::array{2, 2, 2} : std::array{1, 1, 1};
  options.shape = shape;
  RefinementForest forest(scrambled(distorted_box(options, 0.1, generator), generator));
  const auto templates = all_templates(shape);
  refine_randomly(forest, {templates, shape == CellShape::hexahedron ? 12 : 25, 5, 500}, generator);
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  REQUIRE(hanging.hanging_count() > 0);
  check_interpolation(forest, mesh, hanging);
}

TEST_CASE("chains of hanging nodes over several levels are resolved to masters that do not hang", "[hanging]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto refinement = GENERATE(RefinementTemplate{{2, 2, 2}}, RefinementTemplate{{3, 3, 3}});
  if (shape == CellShape::tetrahedron && refinement != RefinementTemplate{{2, 2, 2}}) return;
  RefinementForest forest(box({2, 2, 2}, shape));
  // Opposite children in turn, so that each new leaf touches nodes that hang on the leaf before: 2/3 of the cell is
  // 0.1010... in halves, 3/4 is 0.2020... in thirds.
  const Eigen::Vector3d target =
      Eigen::Vector3d::Constant(0.5 * (refinement == RefinementTemplate{{2, 2, 2}} ? 2.0 / 3.0 : 3.0 / 4.0));
  int leaf = 0;
  for (int level = 0; level < 5; ++level) {
    const Mesh mesh = forest.leaf_mesh();
    double nearest = 1e300;
    for (int cell = 0; cell < mesh.cell_count(); ++cell) {
      const Eigen::Vector3d centre =
          corner_values(mesh, cell, mesh.nodes).rowwise().sum() / static_cast<double>(corner_count(shape));
      if ((centre - target).norm() >= nearest) continue;
      nearest = (centre - target).norm();
      leaf = mesh.forest_cell[cell];
    }
    forest.refine(leaf, refinement);
  }
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  CHECK(hanging.longest_chain >= (shape == CellShape::hexahedron ? 4 : 2));
  CHECK(hanging.longest_chain <= 15);
  check_interpolation(forest, mesh, hanging);
}

TEST_CASE("one face split in two against three, and an edge among four different cells", "[hanging]") {
  RefinementForest forest(box({2, 2, 2}));
  SECTION("halves against thirds") {
    forest.refine(0, {{2, 2, 2}});
    forest.refine(1, {{3, 3, 3}});
  }
  SECTION("halves one way against halves the other way") {
    forest.refine(0, {{1, 2, 1}});
    forest.refine(1, {{1, 1, 2}});
  }
  SECTION("halves first along one axis here and along the other there") {
    forest.refine(0, {{1, 2, 1}});
    for (int child = 0; child < 2; ++child) forest.refine(forest.cell(0).first_child + child, {{1, 1, 2}});
    forest.refine(1, {{1, 1, 2}});
    forest.refine(forest.cell(1).first_child, {{1, 2, 1}});
  }
  SECTION("four cells around an edge, each split along it by another number") {
    forest.refine(0, {{1, 1, 2}});
    forest.refine(1, {{1, 1, 3}});
    forest.refine(2, {{2, 1, 4}});
  }
  SECTION("many refined cells around an edge") {
    for (int cell = 0; cell < 4; ++cell) forest.refine(cell, {{2, 2, 2}});
    forest.refine(forest.cell(0).first_child + 7, {{3, 3, 3}});
    forest.refine(forest.cell(3).first_child, {{2, 2, 2}});
  }
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  REQUIRE(hanging.hanging_count() > 0);
  check_interpolation(forest, mesh, hanging);
}

TEST_CASE("around an edge halves, quarters and a whole hang on one another in any order", "[hanging]") {
  // The whole edge is that of the smallest cells: its demand on the middle comes after the quarters hang on the middle.
  std::array<RefinementTemplate, 4> around = {{{{1, 1, 2}}, {{1, 1, 4}}, {{2, 2, 4}}, {{3, 2, 1}}}};
  std::array<int, 4> order = {0, 1, 2, 3};
  do {
    CAPTURE(order);
    RefinementForest forest(box({2, 2, 1}));
    for (int cell = 0; cell < 4; ++cell) forest.refine(cell, around[static_cast<std::size_t>(order[cell])]);
    const Mesh mesh = forest.leaf_mesh();
    const HangingNodes hanging = find_hanging_nodes(forest, mesh);
    check_interpolation(forest, mesh, hanging);
    int on_edge = 0;
    for (int node = 0; node < mesh.node_count(); ++node) {
      const Eigen::Vector3d X = mesh.nodes.col(node);
      if (std::abs(X[0] - 0.5) + std::abs(X[1] - 0.5) > 1e-12 || X[2] < 1e-12 || X[2] > 1.0 - 1e-12) continue;
      ++on_edge;
      REQUIRE(hanging.row_start[node + 1] - hanging.row_start[node] == 2);  // the ends of the whole edge
    }
    CHECK(on_edge == 3);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_CASE("halves nested twice beside quarters do not hang on their common face", "[hanging]") {
  RefinementForest forest(box({2, 1, 1}));
  forest.refine(0, {{4, 4, 4}});
  forest.refine(1, {{2, 2, 2}});
  for (int child = 0; child < 8; ++child) forest.refine(forest.cell(1).first_child + child, {{2, 2, 2}});
  const Mesh mesh = forest.leaf_mesh();
  CHECK(mesh.node_count() == 9 * 5 * 5);
  CHECK(find_hanging_nodes(forest, mesh).hanging_count() == 0);
}

TEST_CASE("where the leaves leave a choice of what hangs, no weight is negative and rows sum to one", "[hanging]") {
  // Seeds of 3,000 at which pivots smaller than the largest coefficient gave weights down to -1.
  const unsigned seed = GENERATE(65u, 107u, 1508u, 1549u, 1762u, 2022u, 2092u, 2738u);
  CAPTURE(seed);
  std::mt19937 generator(seed);
  BoxMeshOptions options;
  options.cells = {2, 2, 1};
  RefinementForest forest(scrambled(distorted_box(options, 0.1, generator), generator));
  refine_randomly(forest, {all_templates(), 12, 3, 300}, generator);
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  REQUIRE(hanging.hanging_count() > 20);
  double sum_error = 0.0;
  for (int node = 0; node < mesh.node_count(); ++node)
    sum_error =
        std::max(sum_error, std::abs(std::accumulate(hanging.weight.begin() + hanging.row_start[node],
                                                     hanging.weight.begin() + hanging.row_start[node + 1], -1.0)));
  CHECK(*std::min_element(hanging.weight.begin(), hanging.weight.end()) >= 0.0);
  CHECK(sum_error <= 4e-15);  // some dozens of terms no larger than one
}

TEST_CASE("a mesh without refinement or refined alike everywhere has no hanging node", "[hanging]") {
  for (const auto& refinement : {RefinementTemplate{{2, 2, 2}}, RefinementTemplate{{3, 1, 2}}}) {
    RefinementForest forest(box({2, 3, 2}));
    CHECK(find_hanging_nodes(forest, forest.leaf_mesh()).hanging_count() == 0);
    for (const int leaf : leaves(forest)) forest.refine(leaf, refinement);
    CHECK(find_hanging_nodes(forest, forest.leaf_mesh()).hanging_count() == 0);
  }
}

TEST_CASE("T spans all conforming fields where cells are split in 2x2x2", "[hanging][dimension]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(range(1u, 7u));
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  RefinementForest forest(
      scrambled(box(shape == CellShape::hexahedron ? std::array{2, 2, 1} : std::array{1, 1, 1}, shape), generator));
  const std::vector<RefinementTemplate> templates = {{{2, 2, 2}}};
  refine_randomly(forest, {templates, 6, 4, 80}, generator);
  const Dimension found = dimension(forest);
  REQUIRE(found.hanging > 0);
  CHECK(found.reduced == found.nullity);
  CHECK_THAT(found.residual, WithinAbs(0.0, 1e-12));
}

TEST_CASE("T spans all conforming fields where faces are split in 2 and in 3", "[hanging][dimension]") {
  const auto split = GENERATE(std::array<RefinementTemplate, 2>{{{{2, 2, 2}}, {{3, 3, 3}}}},
                              std::array<RefinementTemplate, 2>{{{{2, 3, 3}}, {{2, 2, 2}}}},
                              std::array<RefinementTemplate, 2>{{{{3, 2, 3}}, {{2, 3, 2}}}},
                              std::array<RefinementTemplate, 2>{{{{4, 4, 4}}, {{3, 3, 3}}}});
  RefinementForest forest(box({2, 2, 1}));
  forest.refine(0, split[0]);
  forest.refine(1, split[1]);
  forest.refine(2, split[1]);
  const Dimension found = dimension(forest);
  REQUIRE(found.hanging > 0);
  CHECK(found.reduced == found.nullity);
  CHECK_THAT(found.residual, WithinAbs(0.0, 1e-12));
}

TEST_CASE("on random meshes T gives up few conforming fields and adds none", "[hanging][dimension]") {
  std::mt19937 generator(11);
  const auto templates = all_templates();
  int given_up = 0, hanging = 0;
  for (int trial = 0; trial < 25; ++trial) {
    CAPTURE(trial);
    RefinementForest forest(scrambled(box({2, 2, 1}), generator));
    refine_randomly(forest, {templates, 4, 3, 60}, generator);
    const Dimension found = dimension(forest);
    CHECK(found.reduced <= found.nullity);
    CHECK(found.reduced >= found.nullity - 3);
    CHECK_THAT(found.residual, WithinAbs(0.0, 1e-11));
    given_up += found.nullity - found.reduced;
    hanging += found.hanging;
  }
  CHECK(hanging > 500);
  INFO("conforming fields given up to keep boundary rows on their faces: " << given_up);
  CHECK(given_up <= 5);
}

TEST_CASE("a bend that two faces of the body share is given up", "[hanging][dimension]") {
  // Halves first along one axis here and along the other there, in one quarter of a cell.
  RefinementForest forest(box({2, 1, 1}));
  const auto child = [&](int cell, int k) { return forest.cell(cell).first_child + k; };
  forest.refine(0, {{2, 1, 1}});
  const int half = child(0, 0);
  forest.refine(half, {{2, 1, 1}});
  const int outer = child(half, 0), inner = child(half, 1);
  forest.refine(outer, {{2, 1, 2}});
  forest.refine(child(outer, 1), {{1, 2, 1}});
  forest.refine(inner, {{1, 2, 1}});
  forest.refine(child(inner, 0), {{1, 1, 2}});
  const Dimension found = dimension(forest);
  CHECK(found.nullity == 29);
  CHECK(found.reduced == 28);
  CHECK_THAT(found.residual, WithinAbs(0.0, 1e-12));
  const Mesh mesh = forest.leaf_mesh();
  check_interpolation(forest, mesh, find_hanging_nodes(forest, mesh));
}

TEST_CASE("rows of T are found on coarsened levels too", "[hanging]") {
  std::mt19937 generator(12);
  RefinementForest forest(scrambled(box({2, 2, 2}), generator));
  const auto templates = all_templates();
  refine_randomly(forest, {templates, 10, 5, 500}, generator);
  const std::vector<int> heights = forest.heights();
  const int top = *std::max_element(heights.begin(), heights.begin() + 8);
  REQUIRE(top >= 2);
  for (int height = 0; height <= top; ++height) {
    const Mesh mesh = forest.leaf_mesh(height);
    check_interpolation(forest, mesh, find_hanging_nodes(forest, mesh));
  }
  CHECK(forest.leaf_mesh(top).cell_count() == 8);
}
