#include "verification/studies/smooth_solution.hpp"

#include <algorithm>
#include <cmath>

#include "verification/support/catch.hpp"

using namespace finegauge;

// Bands: theory gives orders 1 (energy) and 2 (displacement) for trilinear cells on smooth solutions; 0.05 and 0.1 are
// what the next terms of the expansion leave at n = 16. Recovered stresses are better than order 1 inside and of lower
// order in the layer of boundary cells, whose share falls with h: above 1.7 and, as linear polynomials lie under the
// patches, not above 2.2. All orders are those of the last pair of grids, 8 to 16.

namespace {

void check_optimal_orders(const SmoothTable& table) {
  CHECK_THAT(last_order(table.energy()), WithinAbs(1.0, 0.05));
  CHECK_THAT(last_order(table.displacement()), WithinAbs(2.0, 0.1));
  CHECK(last_order(table.recovered_stress()) > 1.7);
  CHECK(last_order(table.recovered_stress()) < 2.2);
  // Absolute: a wrong source can leave the orders as they are. 5 % and 0.6 % were found; a quarter less or more would
  // be another problem.
  CHECK_THAT(table.rows.back().energy_error, WithinRel(0.053, 0.1));
  CHECK_THAT(table.rows.back().displacement_error, WithinRel(0.0061, 0.15));
}

void check_estimate(const SmoothTable& table, double band) {
  const SmoothRow& coarse = table.rows.front();
  const SmoothRow& fine = table.rows.back();
  CHECK_THAT(fine.effectivity, WithinAbs(1.0, band));
  CHECK(std::abs(fine.effectivity - 1.0) < std::abs(coarse.effectivity - 1.0));  // it tends to one
  // Single cells may be off, half of them are not, and nine of ten stay within a factor of 1.5.
  CHECK_THAT(fine.cell_effectivity_p50, WithinAbs(1.0, 0.1));
  CHECK(fine.cell_effectivity_p5 > 1.0 / 1.5);
  CHECK(fine.cell_effectivity_p95 < 1.5);
}

SmoothCase near_incompressible(Dilatation dilatation, double perturbation) {
  SmoothCase the_case;
  the_case.exact = isochoric_solution();
  the_case.material.poisson_ratio = 0.4999;
  the_case.material.dilatation = dilatation;
  the_case.perturbation = perturbation;
  return the_case;
}

}  // namespace

TEST_CASE("on a smooth solution regular cells have optimal orders and the estimate is exact within 5 %", "[smooth]") {
  const SmoothTable table = smooth_table({});
  INFO(table.text());
  check_optimal_orders(table);
  check_estimate(table, 0.05);
}

TEST_CASE("perturbed cells keep the orders, and the estimate within 8 %", "[smooth]") {
  SmoothCase the_case;
  the_case.perturbation = 0.2;
  the_case.seed = GENERATE(1u, 2u, 3u);
  const SmoothTable table = smooth_table(the_case);
  INFO(table.text());
  REQUIRE(table.rows.back().energy_error > 1.05 * solve_smooth_case({}, 16).energy_error);  // they are distorted
  check_optimal_orders(table);
  check_estimate(table, 0.08);
}

TEST_CASE("an octant refined by any template keeps the orders, and the estimate within 8 %", "[smooth][hanging]") {
  SmoothCase the_case;
  the_case.octant =
      GENERATE(RefinementTemplate{{2, 2, 2}}, RefinementTemplate{{3, 3, 3}}, RefinementTemplate{{2, 3, 3}},
               RefinementTemplate{{2, 2, 1}}, RefinementTemplate{{4, 1, 2}});
  const SmoothTable table = smooth_table(the_case);
  INFO(table.text());
  REQUIRE(table.rows.front().hanging_nodes > 0);
  REQUIRE(table.rows.back().hanging_nodes > 0);
  check_optimal_orders(table);
  check_estimate(table, 0.08);
}

TEST_CASE("perturbed cells with a refined octant keep the orders, and the estimate within 8 %", "[smooth][hanging]") {
  SmoothCase the_case;
  the_case.perturbation = 0.2;
  the_case.octant = RefinementTemplate{{2, 2, 2}};
  const SmoothTable table = smooth_table(the_case);
  INFO(table.text());
  REQUIRE(table.rows.back().hanging_nodes > 0);
  check_optimal_orders(table);
  check_estimate(table, 0.08);
}

TEST_CASE("errors are integrated to five digits", "[smooth]") {
  SmoothCase the_case;
  the_case.perturbation = 0.2;
  the_case.octant = RefinementTemplate{{2, 3, 3}};
  const int n = GENERATE(4, 8);
  CAPTURE(n);
  const SmoothRow four = solve_smooth_case(the_case, n, 4), five = solve_smooth_case(the_case, n, 5);
  CHECK_THAT(four.displacement_error, WithinRel(five.displacement_error, 1e-5));
  CHECK_THAT(four.energy_error, WithinRel(five.energy_error, 1e-5));
  CHECK_THAT(four.recovered_stress_error, WithinRel(five.recovered_stress_error, 1e-5));
  CHECK_THAT(four.effectivity, WithinRel(five.effectivity, 1e-5));
  // And two points, the estimate's own rule, would not do: the comparison can tell rules apart.
  CHECK(std::abs(solve_smooth_case(the_case, n, 2).energy_error / five.energy_error - 1.0) > 1e-3);
}

TEST_CASE("away from incompressibility the standard hexahedron has optimal orders on an isochoric field", "[smooth]") {
  SmoothCase the_case;
  the_case.exact = isochoric_solution();
  the_case.material.poisson_ratio = 0.4;
  const SmoothTable table = smooth_table(the_case);
  INFO(table.text());
  CHECK_THAT(last_order(table.energy()), WithinAbs(1.0, 0.05));
  CHECK_THAT(last_order(table.displacement()), WithinAbs(2.0, 0.1));
  // An independent code on the same meshes has 4.69e-4 and 2.08 at the inner nodes, to the digits given.
  CHECK_THAT(last_order(table.nodal()), WithinAbs(2.08, 0.006));
  CHECK_THAT(table.rows.back().nodal_error, WithinAbs(4.69e-4, 0.006e-4));
}

TEST_CASE("at nu = 0.4999 standard hexahedra lock", "[smooth][locking]") {
  const double perturbation = GENERATE(0.0, 0.2);
  const SmoothTable table = smooth_table(near_incompressible(Dilatation::standard, perturbation));
  INFO(table.text());
  // Tens of percent that refinement does not reduce, while the energy norm and the estimate look perfect.
  CHECK(last_order(table.displacement()) < 0.5);
  CHECK(table.rows.back().displacement_error > 0.1);
  CHECK(table.rows.back().nodal_error > 0.1);
  CHECK_THAT(last_order(table.energy()), WithinAbs(1.0, 0.05));
  CHECK_THAT(table.rows.back().effectivity, WithinAbs(1.0, 0.05));
}

TEST_CASE("at nu = 0.4999 the mean dilatation keeps order 2 and errors below one percent", "[smooth][locking]") {
  const double perturbation = GENERATE(0.0, 0.2);
  const SmoothTable table = smooth_table(near_incompressible(Dilatation::mean, perturbation));
  INFO(table.text());
  CHECK_THAT(last_order(table.displacement()), WithinAbs(2.0, 0.1));
  // Nodal values carry the chance of the perturbation, which fades faster than order 2: 1.95 without, 2.1 to 2.5 with.
  CHECK_THAT(last_order(table.nodal()), WithinAbs(2.25, 0.4));
  CHECK(table.rows.back().displacement_error < 0.01);
  CHECK(table.rows.back().nodal_error < 0.01);
  CHECK(table.rows.back().energy_error < 0.08);  // 0.060 and 0.070; with the dilatation at each point it is above 1
  CHECK_THAT(table.rows.back().effectivity, WithinAbs(1.0, 0.08));
  CHECK(table.rows.back().displacement_error > 0.005);  // trilinear cells cannot follow the field better than this
  CHECK_THAT(last_order(table.energy()), WithinAbs(1.0, 0.05));
}

TEST_CASE("a compressive load near incompressibility: locked energies look perfect, displacements do not converge",
          "[smooth][locking]") {
  SmoothCase the_case;
  the_case.material.poisson_ratio = 0.4999;
  const SmoothTable standard = smooth_table(the_case);
  INFO(standard.text());
  CHECK_THAT(last_order(standard.energy()), WithinAbs(1.0, 0.05));
  CHECK_THAT(standard.rows.back().effectivity, WithinAbs(1.0, 0.05));
  CHECK(last_order(standard.displacement()) < 0.5);

  the_case.material.dilatation = Dilatation::mean;
  const SmoothTable mean = smooth_table(the_case);
  INFO(mean.text());
  CHECK_THAT(last_order(mean.displacement()), WithinAbs(2.0, 0.1));
}

TEST_CASE("with the mean dilatation the error in the displacement grows with the pressure that the load carries",
          "[smooth][locking]") {
  // The field changes its volume, so that the load has a gradient part that grows as bulk / mu. The element is not
  // pressure-robust (John, Linke, Merdon, Neilan & Rebholz 2017): that part deflects it, ten times more for each nine
  // that nu gains, on one and the same mesh. A limit of the method, not of the isochoric problems above.
  SmoothCase the_case;
  the_case.material.dilatation = Dilatation::mean;
  the_case.perturbation = 0.2;
  the_case.material.poisson_ratio = 0.499;
  const double less = solve_smooth_case(the_case, 8).displacement_error;
  the_case.material.poisson_ratio = 0.4999;
  const double more = solve_smooth_case(the_case, 8).displacement_error;
  CHECK_THAT(more / less, WithinAbs(10.0, 0.5));
}

TEST_CASE("every case of the study solves and names itself", "[smooth]") {
  std::vector<std::string> names;
  for (const SmoothCase& the_case : smooth_solution_cases()) {
    const SmoothTable table = smooth_table(the_case, {4});
    INFO(table.name);
    CHECK(std::find(names.begin(), names.end(), table.name) == names.end());
    names.push_back(table.name);
    CHECK(table.rows.front().energy_error > 0.0);
    CHECK((table.rows.front().hanging_nodes > 0) == the_case.octant.has_value());
  }
  CHECK(names.size() == 17);
}
