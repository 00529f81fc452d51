#include "core/adapt/marking.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// Small whole numbers: their squares and sums are exact, and there are ties and zeros.
std::vector<double> whole_numbers(std::mt19937& generator, int count) {
  std::uniform_int_distribution<int> digit(0, 5);
  std::vector<double> eta(count);
  for (double& value : eta) value = digit(generator);
  return eta;
}

double sum_of_squares(const std::vector<double>& eta, const std::vector<int>& cells) {
  double sum = 0.0;
  for (const int cell : cells) sum += eta[cell] * eta[cell];
  return sum;
}

/// Size of the smallest set of cells with Σ eta² >= share · Σ eta², by trying all sets.
int smallest_bulk(const std::vector<double>& eta, double share) {
  const double total = std::inner_product(eta.begin(), eta.end(), eta.begin(), 0.0);
  int smallest = static_cast<int>(eta.size());
  for (unsigned set = 0; set < (1u << eta.size()); ++set) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t cell = 0; cell < eta.size(); ++cell)
      if (set >> cell & 1u) {
        sum += eta[cell] * eta[cell];
        ++count;
      }
    if (sum >= share * total) smallest = std::min(smallest, count);
  }
  return smallest;
}

bool is_strictly_ascending(const std::vector<int>& cells) {
  return std::adjacent_find(cells.begin(), cells.end(), std::greater_equal<>()) == cells.end();
}

}  // namespace

TEST_CASE("bulk marking finds a smallest set that holds the bulk of the error", "[marking]") {
  std::mt19937 generator(7);
  int ties = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<double> eta = whole_numbers(generator, 9);
    // theta² = 1/4 and 9/16 are exact: equality with the bulk occurs and must count as reached.
    const double theta = std::array{0.25, 0.5, 0.75, 1.0}[trial % 4];
    CAPTURE(eta, theta);
    const std::vector<int> marked = mark_bulk(eta, theta);
    const double total = std::inner_product(eta.begin(), eta.end(), eta.begin(), 0.0);
    const int nonzero = static_cast<int>(eta.size() - std::count(eta.begin(), eta.end(), 0.0));
    CHECK(is_strictly_ascending(marked));
    CHECK(sum_of_squares(eta, marked) >= theta * theta * total);
    CHECK(static_cast<int>(marked.size()) == smallest_bulk(eta, theta * theta));
    if (theta == 1.0) CHECK(static_cast<int>(marked.size()) == nonzero);
    // Among equals the first cells are taken.
    for (const int cell : marked)
      for (int other = 0; other < cell; ++other)
        if (eta[other] == eta[cell]) {
          CHECK(std::binary_search(marked.begin(), marked.end(), other));
          ++ties;
        }
  }
  REQUIRE(ties > 0);
}

TEST_CASE("bulk marking keeps small errors in its sum and takes any magnitude", "[marking]") {
  // A thousand errors of 1e-10 beside a large one: with theta = 1 nothing may be left out.
  std::vector<double> eta(1000, 1e-10);
  eta[500] = 1.0;
  CHECK(mark_bulk(eta, 1.0).size() == 1000);
  CHECK(mark_bulk(eta, 0.5) == std::vector{500});
  CHECK(mark_bulk(eta, 1e-12) == std::vector{500});
  // Squares of these under- and overflow.
  CHECK(mark_bulk(std::vector{3e-200, 4e-200, 0.0}, 0.75) == std::vector{1});
  CHECK(mark_bulk(std::vector{3e200, 4e200, 0.0}, 0.85) == std::vector{0, 1});
}

TEST_CASE("maximum, fraction and threshold agree with their definitions", "[marking]") {
  std::mt19937 generator(11);
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<double> eta = whole_numbers(generator, 10);
    const double theta = std::array{0.2, 0.4, 0.6, 1.0}[trial % 4];
    CAPTURE(eta, theta);
    const double largest = *std::max_element(eta.begin(), eta.end());
    std::vector<int> by_maximum, by_threshold, order(10);
    for (int cell = 0; cell < 10; ++cell) {
      if (eta[cell] > 0.0 && eta[cell] >= theta * largest) by_maximum.push_back(cell);
      if (eta[cell] > 2.0) by_threshold.push_back(cell);
    }
    CHECK(mark_maximum(eta, theta) == by_maximum);
    CHECK(mark_above(eta, 2.0) == by_threshold);

    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return eta[a] > eta[b]; });
    order.resize(static_cast<std::size_t>(10.0 * theta + 0.5));
    std::erase_if(order, [&](int cell) { return eta[cell] == 0.0; });
    std::sort(order.begin(), order.end());
    CHECK(mark_fraction(eta, theta) == order);
  }
}

TEST_CASE("a positive share marks at least one cell and exact shares are not rounded up", "[marking]") {
  const std::vector<double> eta = {1.0, 3.0, 2.0, 3.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0};
  CHECK(mark_fraction(eta, 0.001) == std::vector{1});
  CHECK(mark_fraction(eta, 0.1 + 0.2) == std::vector{1, 2, 3});  // 0.30000000000000004
  CHECK(mark_fraction(eta, 0.0).empty());
  CHECK(mark_fraction(eta, 1.0).size() == 9);
}

TEST_CASE("no error marks no cell", "[marking]") {
  for (const std::vector<double>& eta : {std::vector<double>(5, 0.0), std::vector<double>{}}) {
    CHECK(mark_maximum(eta, 0.3).empty());
    CHECK(mark_bulk(eta, 0.5).empty());
    CHECK(mark_fraction(eta, 0.5).empty());
    CHECK(mark_above(eta, 0.0).empty());
  }
}

TEST_CASE("an estimate or a parameter that is no number or out of range is refused", "[marking]") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> eta = {1.0, 2.0};
  for (const double theta : {0.0, -0.1, 1.1, nan}) {
    CAPTURE(theta);
    CHECK_THROWS_AS(mark_maximum(eta, theta), std::invalid_argument);
    CHECK_THROWS_AS(mark_bulk(eta, theta), std::invalid_argument);
    if (theta != 0.0) CHECK_THROWS_AS(mark_fraction(eta, theta), std::invalid_argument);
    if (!(theta >= 0.0)) CHECK_THROWS_AS(mark_above(eta, theta), std::invalid_argument);
  }
  for (const double bad : {nan, -1.0, infinity}) {
    const std::vector<double> spoiled = {1.0, bad, 2.0};
    CAPTURE(bad);
    CHECK_THROWS_AS(mark_maximum(spoiled, 0.3), std::invalid_argument);
    CHECK_THROWS_AS(mark_bulk(spoiled, 0.3), std::invalid_argument);
    CHECK_THROWS_AS(mark_fraction(spoiled, 0.3), std::invalid_argument);
    CHECK_THROWS_AS(mark_above(spoiled, 0.3), std::invalid_argument);
  }
}
