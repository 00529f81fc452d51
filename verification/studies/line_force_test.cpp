#include "verification/studies/line_force.hpp"

#include <cmath>
#include <numbers>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// The means of the last rises.
double mean_rise(const std::vector<LineForceRow>& rows, int count) {
  return (rows.back().displacement - rows[rows.size() - 1 - count].displacement) / count;
}

}  // namespace

TEST_CASE("a force on a line has no mesh limit: ln 2 / (2 pi) per halving", "[line-force]") {
  const auto rows = line_force_table({});
  INFO(to_string(rows));
  REQUIRE(rows.back().hanging_nodes > 100);
  for (std::size_t level = rows.size() - 4; level < rows.size(); ++level)
    CHECK_THAT(rows[level].rise, WithinRel(line_force_rise, 0.01));
  // For ever: the same to the solver's round-off, since each level adds the same ring of cells.
  CHECK_THAT(rows.back().rise - rows[rows.size() - 2].rise, WithinAbs(0.0, 1e-6));
  // Elsewhere the solution converges, to what cells of 1/16 m there allow: 1.4 % at 1/4 m, by four per halving.
  CHECK_THAT(rows.back().at_distance, WithinRel(line_displacement_at(0.5), 2e-3));
  CHECK_THAT(rows.front().at_distance / line_displacement_at(0.5), WithinAbs(0.986, 0.005));
}

TEST_CASE("the rise per halving is right to the square of the refined zone's fineness", "[line-force]") {
  const auto narrow = line_force_table({.levels = 6, .zone = 3.0}), wide = line_force_table({.levels = 6, .zone = 6.0});
  INFO(to_string(narrow) << to_string(wide));
  const double ratio = (narrow.back().rise - line_force_rise) / (wide.back().rise - line_force_rise);
  CHECK(ratio > 3.0);  // 4 and the higher orders
  CHECK(ratio < 5.0);
}

TEST_CASE("a force spread over a fixed radius has a mesh limit, that of the circle", "[line-force]") {
  const double r = 0.1;
  const auto rows = line_force_table({.radius = r, .ring_points = 256, .levels = 7});
  INFO(to_string(rows) << "limit " << spread_line_displacement(r));
  REQUIRE(rows.back().h < r / 16);
  for (std::size_t level = rows.size() - 2; level < rows.size(); ++level)
    CHECK(std::abs(rows[level].rise) < 0.01 * line_force_rise);
  CHECK_THAT(rows.back().displacement, WithinRel(spread_line_displacement(r), 2e-3));
  CHECK_THAT(rows.back().at_distance, WithinRel(line_displacement_at(0.5), 2e-3));
  // Radii differ by ln(r1 / r2) / (2 pi).
  const auto wider = line_force_table({.radius = 2 * r, .ring_points = 256, .levels = 7});
  CHECK_THAT(rows.back().displacement - wider.back().displacement, WithinRel(line_force_rise, 0.01));
}

TEST_CASE("a ring of eight points is eight forces: an eighth of the rise is back in fine cells", "[line-force]") {
  const double r = 0.1;
  const auto rows = line_force_table({.radius = r, .ring_points = 8, .levels = 8});
  INFO(to_string(rows) << "limit of the circle " << spread_line_displacement(r));
  // Single rises scatter, as the points fall elsewhere in their cells at each level; they are bounded, the sum is not.
  CHECK_THAT(mean_rise(rows, 5), WithinRel(line_force_rise / 8.0, 0.25));
  // Down to cells of half the radius the ring is as good as the circle in the same cells.
  const auto circle = line_force_table({.radius = r, .ring_points = 256, .levels = 2});
  INFO(to_string(circle));
  for (std::size_t level = 0; level < circle.size(); ++level)
    CHECK_THAT(rows[level].displacement, WithinRel(circle[level].displacement, 0.03));
  CHECK(rows.back().displacement > 1.15 * spread_line_displacement(r));
}
