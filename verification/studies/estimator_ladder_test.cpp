#include "verification/studies/estimator_ladder.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <set>
#include <stdexcept>

#include "verification/studies/holdout.hpp"
#include "verification/support/check_claims.hpp"
#include "verification/support/tetrahedra_of.hpp"
#include "verification/support/wedge_mesh.hpp"

using namespace finegauge;

TEST_CASE("on every rung scenes' estimate is within its certified range and the equilibrated one above the error",
          "[ladder]") {
  const Evidence evidence = estimator_ladder_evidence({});
  check_claims(evidence, 60);
}

TEST_CASE(
    "problems that the certificate does not rest on have their error where it says, but for misses that are known",
    "[holdout]") {
  check_claims(holdout_evidence({}), 16);
}

TEST_CASE("a graded reference knows the error to what it says", "[holdout]") {
  // The paper's L-shape: its energy is known from graded cubic meshes (lshape_rung in estimator_rungs.cpp).
  std::vector<HoldoutProblem> problems = known_holdout_problems();
  HoldoutProblem& l_shape = *std::ranges::find(problems, "L-shape, nu 0.2", &HoldoutProblem::name);
  l_shape.problem.material.poisson_ratio = 0.3;
  FactorCache factors;
  const double computed =
      solve_static(RefinementForest(l_shape.mesh), l_shape.problem, nullptr, factors).estimate.energy_norm;
  const double exact = std::sqrt(2.0 * 0.04602075 / (computed * computed) - 1.0);
  const HoldoutRow row = measure(l_shape, {.all_meshes = false, .reference_dofs = 9000}).front();
  CAPTURE(exact, row.true_error, row.uncertainty);
  REQUIRE(row.uncertainty > 0.0);
  CHECK(row.uncertainty < 0.1);
  CHECK_THAT(row.true_error / exact, WithinAbs(1.0, row.uncertainty));
}

TEST_CASE("a wedge's parallelograms fill it, and the faces of a crack meet at its tip alone", "[holdout]") {
  constexpr double opening = 2.0 * std::numbers::pi;
  const BaseMesh crack = wedge_mesh({opening, 4, 3, 2, 0.5});
  REQUIRE(validate(crack).empty());
  CHECK(crack.cells.size() == 4 * 3 * 3 * 2);
  CHECK(boundary_faces(crack).size() == 2 * 36 + 2 * (3 * 2) + 4 * (2 * 3) * 2);
  const auto nodes_of = [&](const char* surface) {
    std::set<int> nodes;
    for (const BaseFace& face : crack.surfaces.at(surface))
      for (const int corner : hexahedron_faces[face.face]) nodes.insert(crack.cells[face.cell][corner]);
    return nodes;
  };
  const std::set<int> first = nodes_of("ray_first"), last = nodes_of("ray_last");
  std::vector<int> common;
  std::ranges::set_intersection(first, last, std::back_inserter(common));
  CHECK(common.size() == 3);
  for (const int node : common) CHECK(crack.nodes.col(node).head<2>().isZero());
}

TEST_CASE("hexahedra are split as a box of tetrahedra is, and not where faces would be cut in two ways", "[holdout]") {
  BoxMeshOptions options;
  options.cells = {3, 2, 2};
  options.removed = RemovedBlock{{1, 0, 0}, {3, 1, 2}};
  BaseMesh hexahedra = box_mesh(options);
  options.shape = CellShape::tetrahedron;
  const BaseMesh expected = box_mesh(options), split = tetrahedra_of(hexahedra);
  CHECK(validate(split).empty());
  CHECK(split.nodes == expected.nodes);
  CHECK(split.cells == expected.cells);
  CHECK(split.surfaces == expected.surfaces);
  // A cell whose axes run x -> y -> -x has other diagonals.
  auto& corners = hexahedra.cells.front();
  corners = {corners[2], corners[0], corners[3], corners[1], corners[6], corners[4], corners[7], corners[5]};
  hexahedra.surfaces.clear();
  REQUIRE(validate(hexahedra).empty());
  CHECK_THROWS_AS(tetrahedra_of(hexahedra), std::invalid_argument);
}
