#include "benchmarks/program/frame_statistics.hpp"

#include <algorithm>
#include <limits>
#include <random>
#include <stdexcept>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// By the definition: the smallest time that at least `percent` % of the times do not exceed.
double percentile_by_counting(const std::vector<double>& times, int percent) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const double candidate : times) {
    const auto within = std::count_if(times.begin(), times.end(), [&](double time) { return time <= candidate; });
    if (100 * within >= percent * static_cast<std::ptrdiff_t>(times.size())) smallest = std::min(smallest, candidate);
  }
  return smallest;
}

}  // namespace

TEST_CASE("percentiles are of the nearest rank", "[frame statistics]") {
  const std::vector<double> five = {40, 15, 50, 20, 35};
  CHECK(percentile(five, 1) == 15);
  CHECK(percentile(five, 20) == 15);
  CHECK(percentile(five, 21) == 20);
  CHECK(percentile(five, 40) == 20);
  CHECK(percentile(five, 50) == 35);
  CHECK(percentile(five, 80) == 40);
  CHECK(percentile(five, 81) == 50);
  CHECK(percentile(five, 100) == 50);
  // Of 200 frames two lie above the 99th percentile, of 100 one, of 99 none.
  std::vector<double> many;
  for (int k = 200; k >= 1; --k) many.push_back(k);
  CHECK(percentile(many, 99) == 198);
  CHECK(percentile(std::span(many).last(100), 99) == 99);
  CHECK(percentile(std::span(many).last(99), 99) == 99);
}

TEST_CASE("percentiles are those found by counting, for any number of frames", "[frame statistics]") {
  std::mt19937 generator(5);
  for (int n = 1; n <= 120; ++n) {
    std::vector<double> times(static_cast<std::size_t>(n));
    for (double& time : times) time = static_cast<double>(generator() % 40);  // with ties
    for (const int percent : {1, 7, 50, 95, 99, 100}) {
      CAPTURE(n, percent);
      REQUIRE(percentile(times, percent) == percentile_by_counting(times, percent));
    }
    const FrameStatistics all = frame_times(times);
    REQUIRE(all.p50 == percentile_by_counting(times, 50));
    REQUIRE(all.p95 == percentile_by_counting(times, 95));
    REQUIRE(all.p99 == percentile_by_counting(times, 99));
    REQUIRE(all.max == *std::max_element(times.begin(), times.end()));
  }
}

TEST_CASE("frames later than the deadline are counted, and the longest run of them", "[frame statistics]") {
  const std::vector<double> times = {30, 10, 21, 22, 20, 25, 25, 25, 1, 40, 40};
  const DeadlineMisses misses = deadline_misses(times, 20);  // one frame takes just as long
  CHECK(misses.missed == 8);
  CHECK(misses.longest_streak == 3);
  CHECK(deadline_misses(times, 19.9).longest_streak == 6);
  CHECK(deadline_misses(times, 40).missed == 0);
  CHECK(deadline_misses(times, 40).longest_streak == 0);
  CHECK(deadline_misses(times, 0.5).missed == 11);
  CHECK(deadline_misses(times, 0.5).longest_streak == 11);
  CHECK(deadline_misses(std::span(times).last(3), 20).longest_streak == 2);  // a streak that the run ends in
}

TEST_CASE("each stage has percentiles of its own", "[frame statistics]") {
  std::vector<double> times;
  for (int frame = 1; frame <= 200; ++frame) {
    times.push_back(frame);
    times.push_back(1000.0 - frame);
    times.push_back(frame == 77 ? 9.0 : 0.5);
  }
  const std::vector<StageStatistics> stages = stage_times(times, 3);
  REQUIRE(stages.size() == 3);
  CHECK(stages[0].p50 == 100);
  CHECK(stages[0].p99 == 198);
  CHECK(stages[1].p50 == 899);
  CHECK(stages[1].p99 == 997);
  CHECK(stages[2].p50 == 0.5);
  CHECK(stages[2].p99 == 0.5);  // one in 200 is past it
}

TEST_CASE("statistics of nothing, or of what is no time, are refused", "[frame statistics][input]") {
  const std::vector<double> none, one = {1.0};
  CHECK(frame_times(one).p99 == 1.0);
  CHECK_THROWS_AS(frame_times(none), std::invalid_argument);
  CHECK_THROWS_AS(percentile(none, 50), std::invalid_argument);
  CHECK_THROWS_AS(deadline_misses(none, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(stage_times(none, 3), std::invalid_argument);
  for (const double time : {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const std::vector<double> times = {1.0, time};
    CHECK_THROWS_AS(frame_times(times), std::invalid_argument);
    CHECK_THROWS_AS(percentile(times, 50), std::invalid_argument);
    CHECK_THROWS_AS(deadline_misses(times, 1.0), std::invalid_argument);
    CHECK_THROWS_AS(stage_times(times, 2), std::invalid_argument);
    CHECK_THROWS_AS(deadline_misses(one, time), std::invalid_argument);
  }
  CHECK_THROWS_AS(deadline_misses(one, 0.0), std::invalid_argument);
  for (const int percent : {-1, 0, 101}) CHECK_THROWS_AS(percentile(one, percent), std::invalid_argument);
  for (const int stages : {-1, 0, 2}) CHECK_THROWS_AS(stage_times(one, stages), std::invalid_argument);
}
