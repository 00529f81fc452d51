#include "verification/support/convergence.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "verification/support/catch.hpp"
#include "verification/support/percentile.hpp"

using namespace finegauge;

TEST_CASE("a power law has its exponent as order, between grids and fitted", "[convergence]") {
  const double exponent = GENERATE(0.5445, 1.0, 2.0);
  ErrorSeries series{"power", {0.5, 0.2, 0.125}, {}};
  for (const double h : series.h) series.error.push_back(3.0 * std::pow(h, exponent));
  CHECK_THAT(last_order(series), WithinAbs(exponent, 1e-13));
  CHECK_THAT(fitted_order(series), WithinAbs(exponent, 1e-13));
}

TEST_CASE("the last pair and the fit differ where the errors are no power law", "[convergence]") {
  // log2 of h: 0 -1 -2, of e: 0 -1 -3. Slopes: last 2; least squares (0 + 3) / 2.
  const ErrorSeries series{"bent", {1.0, 0.5, 0.25}, {1.0, 0.5, 0.125}};
  CHECK_THAT(last_order(series), WithinAbs(2.0, 1e-14));
  CHECK_THAT(fitted_order(series), WithinAbs(1.5, 1e-14));
}

TEST_CASE("what has no order is refused", "[convergence]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(last_order({"one grid", {1.0}, {1.0}}), std::invalid_argument);
  CHECK_THROWS_AS(last_order({"no error", {1.0, 0.5}, {1.0, 0.0}}), std::invalid_argument);
  CHECK_THROWS_AS(fitted_order({"not a number", {1.0, 0.5}, {nan, 0.1}}), std::invalid_argument);
  CHECK_THROWS_AS(fitted_order({"same grid", {0.5, 0.5}, {1.0, 0.1}}), std::invalid_argument);
  CHECK_THROWS_AS(fitted_order({"lengths", {1.0, 0.5}, {1.0}}), std::invalid_argument);
}

TEST_CASE("the table shows errors, orders and the fit", "[convergence]") {
  const std::string text = convergence_table({{"energy", {1.0, 0.5, 0.25}, {1.0, 0.5, 0.125}}});
  CAPTURE(text);
  for (const char* part : {"energy", "order", "1.250e-01", "2.000", "1.500"})
    CHECK(text.find(part) != std::string::npos);
  CHECK(convergence_table({{"energy", {1.0}, {0.25}}}).find("2.500e-01") != std::string::npos);
  CHECK(convergence_table({}).empty());
}

TEST_CASE("the percentile of cells is the value of the nearest rank", "[convergence]") {
  const int count = GENERATE(1, 2, 11, 36, 100);
  std::vector<double> values;
  for (int rank = 0; rank < count; ++rank) values.push_back(rank);
  for (const double share : {0.0, 0.05, 0.5, 0.77, 0.95, 1.0}) {
    CAPTURE(count, share);
    const double wanted = share * (count - 1);
    CHECK(std::abs(percentile(values, share) - wanted) <= 0.5);
  }
  CHECK(percentile(values, 0.0) == 0.0);
  CHECK(percentile(values, 1.0) == count - 1);
}
