#include "core/adapt/directional_marking.hpp"

#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "core/adapt/apply_refinements.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// An estimate with the given error and shares in each of the cells of a row of hexahedra.
ErrorEstimate estimate_of(const std::vector<double>& eta, const std::vector<Eigen::Vector3d>& shares) {
  ErrorEstimate estimate;
  estimate.eta = Eigen::Map<const Eigen::VectorXd>(eta.data(), static_cast<Eigen::Index>(eta.size()));
  estimate.direction.resize(3, static_cast<Eigen::Index>(shares.size()));
  for (std::size_t cell = 0; cell < shares.size(); ++cell)
    estimate.direction.col(static_cast<Eigen::Index>(cell)) = shares[cell];
  return estimate;
}

RefinementForest row_of_cells(int cells, CellShape shape = CellShape::hexahedron) {
  BoxMeshOptions options;
  options.cells = {cells, 1, 1};
  options.size = {static_cast<double>(cells), 1.0, 1.0};
  options.shape = shape;
  return RefinementForest(box_mesh(options));
}

std::set<std::array<double, 3>> positions(const Mesh& mesh) {
  std::set<std::array<double, 3>> set;
  for (int node = 0; node < mesh.node_count(); ++node)
    set.insert({mesh.nodes(0, node), mesh.nodes(1, node), mesh.nodes(2, node)});
  return set;
}

}  // namespace

TEST_CASE("a cell is divided along the axes of its error only", "[marking][directional]") {
  const RefinementForest forest = row_of_cells(3);
  // Directional errors sqrt(share) eta: cell 0 (1, 0, 0); cell 1 (0.32, 0.32, 0.21); cell 2 (0.1, 0.1, 0.1).
  const auto estimate = estimate_of({1.0, 0.5, 0.1 * std::sqrt(3.0)}, {{1, 0, 0}, {0.41, 0.41, 0.18}, {1, 1, 1}});
  const auto chosen =
      choose_templates(forest.leaf_mesh(), estimate, {.theta = 0.3, .division = 2, .may_repeat = true}, 100);
  REQUIRE(chosen.size() == 2);
  CHECK(chosen[0].cell == 0);
  CHECK(to_string(chosen[0].refinement) == "4x1x1");  // 1 >= 2 × 0.3: one halving would leave it marked
  CHECK(chosen[1].cell == 1);
  CHECK(to_string(chosen[1].refinement) == "2x2x1");
}

TEST_CASE("without repetition an axis is divided once, in two or in three", "[marking][directional]") {
  const RefinementForest forest = row_of_cells(1);
  const auto estimate = estimate_of({1.0}, {{0.5, 0.5, 0.0}});
  const Mesh mesh = forest.leaf_mesh();
  CHECK(to_string(
            choose_templates(mesh, estimate, {.theta = 0.3, .division = 2, .may_repeat = false}, 9)[0].refinement) ==
        "2x2x1");
  CHECK(
      to_string(choose_templates(mesh, estimate, {.theta = 0.3, .division = 3, .may_repeat = true}, 9)[0].refinement) ==
      "3x3x1");
}

TEST_CASE("no error, or the depth limit, marks nothing", "[marking][directional]") {
  const RefinementForest forest = row_of_cells(1);
  CHECK(choose_templates(forest.leaf_mesh(), estimate_of({0.0}, {{1, 1, 1}}), {}, 9).empty());
  CHECK(choose_templates(forest.leaf_mesh(), estimate_of({1.0}, {{1, 1, 1}}), {}, 0).empty());
}

TEST_CASE("tetrahedra are marked by the maximum strategy", "[marking][directional]") {
  const RefinementForest forest = row_of_cells(1, CellShape::tetrahedron);
  const Mesh mesh = forest.leaf_mesh();
  std::vector<double> eta(static_cast<std::size_t>(mesh.cell_count()), 0.1);
  eta[2] = 1.0;
  const auto estimate = estimate_of(eta, std::vector<Eigen::Vector3d>(eta.size(), Eigen::Vector3d::Constant(1.0 / 3)));
  const auto chosen = choose_templates(mesh, estimate, {.theta = 0.3, .division = 2, .may_repeat = true}, 9);
  REQUIRE(chosen.size() == 1);
  CHECK(chosen[0].cell == 2);
  CHECK(chosen[0].refinement == RefinementTemplate{});
}

TEST_CASE("directional parameters out of range are refused", "[marking][directional][input]") {
  const RefinementForest forest = row_of_cells(1);
  const auto estimate = estimate_of({1.0}, {{1, 0, 0}});
  const Mesh mesh = forest.leaf_mesh();
  for (const double theta : {0.0, -0.3, 1.1, std::numeric_limits<double>::quiet_NaN()})
    CHECK_THROWS_AS(choose_templates(mesh, estimate, {.theta = theta, .division = 2, .may_repeat = true}, 9),
                    std::invalid_argument);
  CHECK_THROWS_AS(choose_templates(mesh, estimate, {.theta = 0.3, .division = 4, .may_repeat = true}, 9),
                  std::invalid_argument);
}

TEST_CASE("a division by four made of two halvings has the same leaves", "[adapt]") {
  RefinementForest nested = row_of_cells(2), direct = row_of_cells(2);
  const RefinementTemplate refinement{{4, 2, 1}};
  CHECK(apply_refinements(nested, nested.leaf_mesh(), {{0, refinement}}) == 1);
  direct.refine(0, refinement);
  CHECK(nested.leaf_count() == direct.leaf_count());
  CHECK(nested.leaf_count() == 1 + 8);
  CHECK(positions(nested.leaf_mesh()) == positions(direct.leaf_mesh()));  // the same bits, not only the same places
  CHECK(nested.heights()[0] == 2);
  CHECK(direct.heights()[0] == 1);
}
