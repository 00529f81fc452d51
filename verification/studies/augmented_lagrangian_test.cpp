#include "verification/studies/augmented_lagrangian.hpp"

#include <algorithm>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

NeedleInBox box_with(AxialLaw axial, LateralLaw lateral) {
  NeedleInBoxOptions options;
  options.refine = true;  // points about a cell apart: closer rows are nearly dependent, and every weight is slow
  options.points = 4;
  options.axial = axial;
  options.lateral = lateral;
  return needle_in_box(options);
}

}  // namespace

TEST_CASE("the forces are those of the dense system over five decades of the weight", "[augmented_lagrangian]") {
  const auto [axial, lateral] = GENERATE(
      std::pair{AxialLaw::bilateral, LateralLaw::bilateral}, std::pair{AxialLaw::unilateral, LateralLaw::bilateral},
      std::pair{AxialLaw::friction, LateralLaw::bilateral}, std::pair{AxialLaw::unilateral, LateralLaw::coulomb});
  const WeightTable table = weight_table(box_with(axial, lateral), {1e1, 1e2, 1e3, 1e4, 1e5, 1e6});
  INFO(table.text());
  for (const WeightRow& row : table.rows) {
    CHECK(row.converged);
    CHECK(row.force_error <= 1e-6);
  }
  // More weight, fewer iterations, until the bounds' own iteration remains.
  CHECK(table.rows[0].iterations >= table.rows[3].iterations + 5);
  CHECK(table.rows[3].iterations <= (axial == AxialLaw::bilateral ? 6 : 15));
  CHECK(table.rows[3].linear_iterations <= 2 * table.rows[3].iterations);
}

TEST_CASE("Uzawa's error shrinks by 1/(1 + w sigma_min) or better, and the condition grows as w",
          "[augmented_lagrangian]") {
  const auto rows =
      error_factors(box_with(AxialLaw::bilateral, LateralLaw::bilateral), {1e-1, 1e0, 1e1, 1e2, 1e3, 1e4});
  for (const ErrorFactorRow& row : rows) {
    CAPTURE(row.kappa, row.bound, row.generic, row.slowest, row.condition);
    CHECK(row.generic <= row.bound * (1.0 + 1e-6));
    CHECK(row.generic > 0.0);
    // Attained; the dense λ is good to some 1e-12 and the factors go down to 1e-4.
    CHECK_THAT(row.slowest, WithinRel(row.bound, 1e-6));
  }
  CHECK(rows.front().bound > 0.9);
  CHECK(rows.back().bound < 0.1);
  // Once the rows dominate, ten times the weight is ten times the condition.
  for (std::size_t k = 4; k < rows.size(); ++k)
    CHECK_THAT(rows[k].condition / rows[k - 1].condition, WithinRel(10.0, 0.1));
}
