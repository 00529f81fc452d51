#include "verification/studies/manufactured_static.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "verification/support/check_claims.hpp"

using namespace finegauge;

namespace {

const StaticCase& case_named(const std::vector<StaticCase>& cases, const std::string& name) {
  const auto found = std::ranges::find(cases, name, &StaticCase::name);
  REQUIRE(found != cases.end());
  return *found;
}

/// Leaves of one size that would fill a base cell, for each size.
std::set<int> leaves_per_base_cell(const RefinementForest& forest) {
  std::set<int> shares;
  const Mesh mesh = forest.leaf_mesh();
  for (const int handle : mesh.forest_cell)
    shares.insert(static_cast<int>(std::lround(1.0 / share_of_base_cell(forest.cell(handle)))));
  return shares;
}

}  // namespace

TEST_CASE("manufactured solutions have their order and their constant on hexahedra and tetrahedra, and do not lock",
          "[manufactured]") {
  const Evidence evidence = manufactured_static_evidence({});
  check_claims(evidence, 120);
  std::set<std::string> names;
  for (const Claim& claim : evidence.claims) names.insert(claim.name);
  // Each of the cases is claimed for.
  for (const auto& cases : {static_cases(false), near_incompressible_cases(false)})
    for (const StaticCase& the_case : cases) CHECK(names.count(the_case.name + "_displacement_order") == 1);
}

TEST_CASE("the meshes of the manufactured solutions are what they are called", "[manufactured]") {
  const std::vector<StaticCase> cases = static_cases(false);
  for (const StaticCase& the_case : cases) {
    INFO(the_case.name);
    for (const int n : {the_case.grids.front(), the_case.grids.back()}) {
      const RefinementForest forest = refined_cube(the_case.mesh, n);
      const Discretization d = discretize(forest, the_case.material, {});
      CHECK(d.mesh.shape == the_case.mesh.shape);
      CHECK((d.hanging.hanging_count() > 0) == !the_case.mesh.levels.empty());
      double volume = 0.0;
      CellGeometry scratch;
      for (int cell = 0; cell < d.mesh.cell_count(); ++cell) volume += d.shapes.geometry(d.mesh, cell, scratch).volume;
      CHECK_THAT(volume, WithinAbs(1.0, 1e-12));
    }
  }
  const auto sizes = [&](const std::string& name) {
    return leaves_per_base_cell(refined_cube(case_named(cases, name).mesh, 8));
  };
  CHECK(sizes("hexahedra_nested_twice") == std::set{1, 8, 8 * 27});
  CHECK(sizes("hexahedra_nested_three_times") == std::set{1, 8, 64, 512});
  CHECK(sizes("hexahedra_mixed") == std::set{1, 8, 18, 27});
  CHECK(sizes("hexahedra_mixed_and_nested") == std::set{1, 8, 27, 8 * 8, 8 * 18, 27 * 8, 27 * 18});
  CHECK(sizes("tetrahedra_nested_twice") == std::set{1, 8, 64});

  // Neighbours in the mixed octant are refined by other templates.
  const RefinementForest mixed = refined_cube(case_named(cases, "hexahedra_mixed").mesh, 4);
  for (const int handle : {0, 1}) REQUIRE_FALSE(mixed.is_leaf(handle));
  CHECK(mixed.cell(0).refinement != mixed.cell(1).refinement);
  CHECK(mixed.cell(0).refinement != mixed.cell(4).refinement);
  CHECK(mixed.cell(0).refinement != mixed.cell(16).refinement);

  // All 19 templates up to turns, and each but the cube's halves once.
  std::set<RefinementTemplate> templates;
  for (const StaticCase& the_case : static_cases(true))
    for (const auto& level : the_case.mesh.levels)
      for (RefinementTemplate refinement : level) {
        std::ranges::sort(refinement.divisions);
        templates.insert(refinement);
      }
  CHECK(templates.size() == 19);
}

TEST_CASE("the closed form of the error fits no other cells", "[manufactured]") {
  // An octant refined along one axis only: the formula knows along which.
  StaticCase the_case;
  the_case.name = "along one axis";
  the_case.mesh.levels = {{{{1, 1, 4}}}};
  const StaticRow row = solve_static_case(the_case, 6);
  CHECK_THAT(row.energy_over_leading, WithinAbs(1.01, 0.01));
  the_case.mesh.levels = {{{{4, 1, 1}}}};
  const double other = leading_energy_error(refined_cube(the_case.mesh, 6).leaf_mesh(), the_case.material,
                                            FieldFormula(the_case.exact.formula));
  the_case.mesh.levels = {{{{1, 1, 4}}}};
  const double own = leading_energy_error(refined_cube(the_case.mesh, 6).leaf_mesh(), the_case.material,
                                          FieldFormula(the_case.exact.formula));
  CHECK(std::abs(other / own - 1.0) > 0.01);
}
