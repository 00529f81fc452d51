#include "benchmarks/measure/cost_against_size.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "verification/support/catch.hpp"

using namespace finegauge;

TEST_CASE("an exact power law is found again, whatever its units and in whatever order", "[cost_against_size]") {
  const double exponent = GENERATE(-0.2, 0.5, 1.0, 1.31, 2.0), factor = GENERATE(1e-9, 3.0);
  std::vector<double> cost;
  const std::vector<double> size{42483, 860, 6075, 18759};
  for (const double n : size) cost.push_back(factor * std::pow(n, exponent));
  const auto law = fit_power_law(size, cost);
  REQUIRE(law);
  CHECK_THAT(law->exponent, WithinAbs(exponent, 1e-12));
  CHECK_THAT(law->factor, WithinRel(factor, 1e-11));
  CHECK_THAT(law->exponent_error, WithinAbs(0.0, 1e-12));
  CHECK_THAT(law->r_squared, WithinAbs(1.0, 1e-12));
}

TEST_CASE("the exponent's error is that of a line through points that scatter", "[cost_against_size]") {
  // log2 of the sizes: 0 1 2 3; of the costs: 0 1 2 3 and off by +1 -1 -1 +1, which is orthogonal to lines. Residual
  // sum of squares 4, with two degrees of freedom 2; sum of squares about the mean 5 of the sizes, 5 + 4 of the costs.
  const std::vector<double> size{1, 2, 4, 8}, cost{2, 1, 2, 16};
  const auto law = fit_power_law(size, cost);
  REQUIRE(law);
  CHECK_THAT(law->exponent, WithinAbs(1.0, 1e-14));
  CHECK_THAT(law->exponent_error, WithinAbs(std::sqrt(2.0 / 5.0), 1e-14));
  CHECK_THAT(law->r_squared, WithinAbs(5.0 / 9.0, 1e-14));
}

TEST_CASE("fewer than three different sizes have no exponent", "[cost_against_size]") {
  CHECK_FALSE(fit_power_law(std::vector{1.0, 2.0}, std::vector{1.0, 2.0}));
  CHECK_FALSE(fit_power_law(std::vector{1.0, 2.0, 2.0, 1.0}, std::vector{1.0, 2.0, 2.1, 1.1}));
  CHECK_FALSE(fit_power_law({}, {}));
  CHECK(fit_power_law(std::vector{1.0, 2.0, 3.0}, std::vector{1.0, 2.0, 2.0}));
}

TEST_CASE("what has no logarithm is refused", "[cost_against_size]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> size{1, 2, 3};
  CHECK_THROWS_AS(fit_power_law(size, std::vector{1.0, 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(fit_power_law(size, std::vector{1.0, 0.0, 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(fit_power_law(size, std::vector{1.0, nan, 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(fit_power_law(std::vector{1.0, -2.0, 3.0}, size), std::invalid_argument);
}

namespace {

/// Error e of n dofs: n^-order; each costs n^1.5 ms.
std::vector<SizedResult> family(const std::string& name, const std::vector<double>& sizes, double order) {
  std::vector<SizedResult> results;
  for (const double n : sizes)
    results.push_back({name, n, std::pow(n, 1.5), {{"eta", std::pow(n, -order)}, {"cells", n}, {"iterations", 8}}});
  return results;
}

}  // namespace

TEST_CASE("two ways are compared at the smallest error that both reach", "[cost_against_size]") {
  // Everywhere 1e-2 at n = 1e4, where the other way, of twice the order, has n = 100, between its sizes.
  const auto full = family("frame/full", {100, 1000, 10000}, 0.5), way = family("frame/local", {10, 90, 1000}, 1.0);
  const auto cost = cost_at_equal_error(full, way, "eta");
  REQUIRE(cost);
  CHECK_THAT(cost->error, WithinRel(1e-2, 1e-12));
  CHECK_THAT(cost->full_size, WithinRel(1e4, 1e-12));
  CHECK_THAT(cost->full_ms, WithinRel(1e6, 1e-12));
  CHECK_THAT(cost->size, WithinRel(100.0, 1e-12));
  CHECK_THAT(cost->time_ms, WithinRel(1e3, 1e-12));

  CHECK_FALSE(cost_at_equal_error(full, way, "true_error"));
  // The one begins with a smaller error than the other ends with.
  CHECK_FALSE(cost_at_equal_error(full, family("frame/local", {1000, 2000, 4000}, 1.0), "eta"));
  CHECK_FALSE(cost_at_equal_error({}, way, "eta"));
}

TEST_CASE("the table has a block for each family and a line for each way", "[cost_against_size]") {
  std::vector<SizedResult> results = family("frame/full", {10000, 100, 1000}, 0.5);
  for (SizedResult& result : family("frame/local", {10, 90, 1000}, 1.0)) results.push_back(result);
  for (SizedResult& result : family("stage", {10, 1000}, 1.0)) results.push_back(result);
  for (SizedResult& result : family("other/local", {10, 90, 1000}, 1.0)) results.push_back(result);
  const std::string text = cost_against_size_table(results);
  CAPTURE(text);
  CHECK_THAT(text, ContainsSubstring("frame/full: 3 sizes, 100 to 10,000 free dofs\n"));
  CHECK_THAT(text, ContainsSubstring("  time [ms]                  1000 to 1e+06        1.50 ± 0.00    1.000\n"));
  CHECK_THAT(text, ContainsSubstring("  iterations                    8 to 8          constant\n"));
  CHECK_THAT(text, ContainsSubstring("  eta                         0.1 to 0.01        -0.50 ± 0.00    1.000\n"));
  CHECK_THAT(text, !ContainsSubstring("cells"));
  CHECK_THAT(text, ContainsSubstring("\n1 families with fewer than three sizes: no exponent\n"));
  CHECK_THAT(text, ContainsSubstring("\nframe/local                        eta        0.0100"));
  CHECK_THAT(text, ContainsSubstring("100.00 dofs 1000.00 time\n"));
  CHECK_THAT(text, !ContainsSubstring("\nother/local "));
  CHECK(cost_against_size_table({}).empty());
}
