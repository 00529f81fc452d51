#include "benchmarks/gate/frame_comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <stdexcept>

#include "benchmarks/gate/calibration_kernel.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// P(W⁺ <= sum) by tossing every sign of the ranks 1 to n in turn.
double cumulative_by_enumeration(int n, double sum) {
  int below = 0;
  for (int signs = 0; signs < 1 << n; ++signs) {
    int positive = 0;
    for (int rank = 1; rank <= n; ++rank)
      if (signs >> (rank - 1) & 1) positive += rank;
    below += positive <= sum;
  }
  return static_cast<double>(below) / (1 << n);
}

std::vector<int> ranks_without_ties(int n) {
  std::vector<int> doubled(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) doubled[static_cast<std::size_t>(i)] = 2 * (i + 1);
  return doubled;
}

/// A machine that nobody would choose: its speed drifts by a random walk over the runs, single runs are off by noise of
/// Student's t with two degrees of freedom (no variance), and one frame in ten is interrupted for several frames' time.
struct NoisyMachine {
  std::mt19937 random;
  double drift = 0.0;

  double heavy() { return std::student_t_distribution<double>(2.0)(random); }
  /// Frames of 1 to 3 ms, every 40th of 5 ms; `slower` multiplies frame k's work.
  template <class Slower>
  RunTimes run(int frames, Slower slower) {
    drift += 0.05 * std::normal_distribution<double>()(random);
    const double of_run = std::exp(drift + 0.02 * heavy());
    RunTimes times;
    for (int k = 0; k < frames; ++k) {
      const double work = (k % 40 == 7 ? 5.0 : 1.0 + 2.0 * k / frames) * slower(k);
      const bool interrupted = std::uniform_int_distribution<int>(0, 9)(random) == 0;
      times.push_back(work * of_run * std::exp(0.02 * heavy()) + (interrupted ? 8.0 : 0.0));
    }
    return times;
  }
};

/// As the gate runs it: blocks in tossed order until no more are wanted.
template <class Slower>
FrameComparison compared(NoisyMachine& machine, const ComparisonRule& rule, Slower slower) {
  constexpr int frames = 200;
  const auto as_ever = [](int) { return 1.0; };
  std::vector<TimeBlock> blocks;
  FrameComparison comparison;
  do {
    TimeBlock block;
    const bool head_first = std::uniform_int_distribution<int>(0, 1)(machine.random) == 0;
    if (head_first) block.head = machine.run(frames, slower);
    block.base = machine.run(frames, as_ever);
    if (!head_first) block.head = machine.run(frames, slower);
    blocks.push_back(std::move(block));
    comparison = compare_frames(blocks, rule);
  } while (wants_more_blocks(comparison, rule));
  return comparison;
}

template <class Slower>
int alarms_of(int comparisons, int percentile, Slower slower) {
  NoisyMachine machine{std::mt19937(20u + static_cast<unsigned>(percentile)), 0.0};
  ComparisonRule rule;
  rule.percentile = percentile;
  int alarms = 0;
  for (int i = 0; i < comparisons; ++i) alarms += compared(machine, rule, slower).alarm;
  return alarms;
}

}  // namespace

TEST_CASE("signed ranks have the critical values of the published tables", "[gate][statistics]") {
  // The largest sum whose one-sided chance is at most 5, 2.5, 1 and 0.5 %, for n = 5 to 25: McCornack, Journal of the
  // American Statistical Association 60 (1965), 864-871; -1 where the tables have none.
  constexpr std::array<std::array<int, 4>, 21> table = {
      {{0, -1, -1, -1},  {2, 0, -1, -1},   {3, 2, 0, -1},    {5, 3, 1, 0},     {8, 5, 3, 1},     {10, 8, 5, 3},
       {13, 10, 7, 5},   {17, 13, 9, 7},   {21, 17, 12, 9},  {25, 21, 15, 12}, {30, 25, 19, 15}, {35, 29, 23, 19},
       {41, 34, 27, 23}, {47, 40, 32, 27}, {53, 46, 37, 32}, {60, 52, 43, 37}, {67, 58, 49, 42}, {75, 65, 55, 48},
       {83, 73, 62, 54}, {91, 81, 69, 61}, {100, 89, 76, 68}}};
  constexpr std::array levels = {0.05, 0.025, 0.01, 0.005};
  for (int n = 5; n <= 25; ++n)
    for (std::size_t level = 0; level < levels.size(); ++level) {
      const int critical = table[static_cast<std::size_t>(n - 5)][level];
      CAPTURE(n, levels[level], critical);
      CHECK(signed_rank_cumulative(ranks_without_ties(n), critical) <= levels[level]);
      CHECK(signed_rank_cumulative(ranks_without_ties(n), critical + 1) > levels[level]);
    }
}

TEST_CASE("chances of signed ranks are those found by tossing every sign", "[gate][statistics]") {
  for (int n = 1; n <= 12; ++n)
    for (int sum = -1; sum <= n * (n + 1) / 2; ++sum) {
      CAPTURE(n, sum);
      REQUIRE(signed_rank_cumulative(ranks_without_ties(n), sum) ==
              Approx(cumulative_by_enumeration(n, sum)).margin(1e-15));
    }
}

TEST_CASE("signed ranks and shifts of published samples", "[gate][statistics]") {
  // Depression scores of nine patients before and after a therapy: Hollander and Wolfe, Nonparametric Statistical
  // Methods, tables 3.1 and examples 3.1, 3.3 and 3.4: T+ = 40, p = 0.0195, a shift of 0.46 within 0.010 to 0.786 (96.1
  // %).
  const std::vector<double> before = {1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30};
  const std::vector<double> after = {0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29};
  std::vector<double> change(before.size());
  std::transform(before.begin(), before.end(), after.begin(), change.begin(), std::minus<>());
  CHECK(signed_ranks(change).positive == 40.0);
  CHECK_THAT(p_value_above(change), WithinAbs(0.01953125, 1e-12));
  const HodgesLehmann shift = hodges_lehmann(change, 0.95);
  CHECK_THAT(shift.shift, WithinAbs(0.46, 1e-12));
  CHECK_THAT(shift.low, WithinAbs(0.010, 1e-12));
  CHECK_THAT(shift.high, WithinAbs(0.786, 1e-12));
  CHECK_THAT(shift.confidence, WithinAbs(0.961, 5e-4));
  // Darwin's crossed and self-fertilized maize, eighths of an inch (1876): a two-sided p of 0.0413.
  const std::vector<double> maize = {49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48};
  CHECK(signed_ranks(maize).positive == 96.0);
  CHECK_THAT(2.0 * p_value_above(maize), WithinAbs(0.0412598, 1e-7));
}

TEST_CASE("differences that tie share their ranks, and those that are zero have none", "[gate][statistics]") {
  const std::vector<double> tied = {1, -1, 2, 2, -2, 3, 0, 0};
  const SignedRanks ranks = signed_ranks(tied);
  CHECK(ranks.doubled_ranks == std::vector<int>{3, 3, 8, 8, 8, 12});
  CHECK(ranks.positive == 1.5 + 4.0 + 4.0 + 6.0);
  // By hand: of the 64 signs of ranks 1.5, 1.5, 4, 4, 4, 6 these reach 15.5 or more.
  int reached = 0;
  constexpr std::array values = {1.5, 1.5, 4.0, 4.0, 4.0, 6.0};
  for (int signs = 0; signs < 64; ++signs) {
    double sum = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += signs >> i & 1 ? values[i] : 0.0;
    reached += sum >= 15.5;
  }
  CHECK_THAT(p_value_above(tied), WithinAbs(reached / 64.0, 1e-15));
  CHECK(p_value_above(std::vector<double>{0.0, 0.0}) == 1.0);
  CHECK(p_value_above(std::vector<double>{}) == 1.0);
  CHECK_THROWS_AS(p_value_above(std::vector<double>{1.0, std::nan("")}), std::invalid_argument);
  CHECK_THROWS_AS(hodges_lehmann(std::vector<double>{}, 0.95), std::invalid_argument);
}

TEST_CASE("the test keeps its level and the interval its confidence on noise without a variance",
          "[gate][statistics]") {
  std::mt19937 random(7);
  std::student_t_distribution<double> heavy(2.0);
  constexpr int samples = 1000, n = 15;
  int rejected = 0, covered = 0;
  double confidence = 0.0;
  for (int sample = 0; sample < samples; ++sample) {
    std::vector<double> differences(n);
    for (double& d : differences) d = heavy(random);
    rejected += p_value_above(differences) <= 0.05;
    const HodgesLehmann shift = hodges_lehmann(differences, 0.95);
    covered += shift.low <= 0.0 && 0.0 <= shift.high;
    confidence = shift.confidence;
  }
  // P(W⁺ <= 30) = 0.0473 for 15, and 95.2 % of the interval: three standard deviations of a thousand tosses.
  CHECK(rejected >= 27);
  CHECK(rejected <= 67);
  CHECK(confidence == Approx(0.952).margin(1e-3));
  CHECK(covered >= 932);
  CHECK(covered <= 972);
}

TEST_CASE("a build against itself raises no alarm on a machine that drifts and interrupts", "[gate][statistics]") {
  const auto same = [](int) { return 1.0; };
  CHECK(alarms_of(60, 99, same) == 0);
  CHECK(alarms_of(60, 50, same) == 0);
}

TEST_CASE("fifteen per cent is caught in the noise, and five is none", "[gate][statistics]") {
  CHECK(alarms_of(40, 99, [](int) { return 1.15; }) >= 36);
  CHECK(alarms_of(40, 50, [](int) { return 1.15; }) >= 36);
  CHECK(alarms_of(40, 50, [](int) { return 1.05; }) <= 1);
}

TEST_CASE("slower worst frames are the 99th percentile's affair and not the median's", "[gate][statistics]") {
  const auto worst = [](int k) { return k % 40 == 7 ? 1.3 : 1.0; };
  CHECK(alarms_of(20, 99, worst) >= 18);
  CHECK(alarms_of(20, 50, worst) == 0);
}

TEST_CASE("a percentile's frames are found by medians over the runs", "[gate][statistics]") {
  std::vector<RunTimes> runs(5, RunTimes(200));
  for (RunTimes& run : runs) std::iota(run.begin(), run.end(), 1.0);
  runs[1][20] = runs[3][20] = 1e6;  // interrupted twice in five: not the frame's own
  CHECK(frames_at_percentile(runs, 99) == std::vector<int>{197, 198, 199});
  CHECK(frames_at_percentile(runs, 100) == std::vector<int>{199});
  CHECK(frames_at_percentile(runs, 50).size() == 101);
  runs[0][20] = 1e6;  // three times
  CHECK(frames_at_percentile(runs, 100) == std::vector<int>{20});
}

TEST_CASE("a comparison that could have seen nothing is undecided", "[gate][statistics]") {
  std::vector<TimeBlock> blocks;
  for (int i = 0; i < 12; ++i) blocks.push_back({{i % 2 == 0 ? 2.0 : 1.0}, {i % 2 == 0 ? 1.0 : 2.0}});
  CHECK_FALSE(compare_frames(blocks, {}).decided);
  CHECK_FALSE(compare_frames(blocks, {}).alarm);
  for (TimeBlock& block : blocks) block = {{1.5}, {1.0}};
  CHECK(compare_frames(blocks, {}).alarm);
  CHECK(compare_frames(blocks, {}).ratio == Approx(1.5));
  CHECK(compare_frames(blocks, {}).p_value == Approx(std::ldexp(1.0, -12)));
  blocks[0].base.push_back(1.0);  // the builds make different numbers of frames
  CHECK_FALSE(compare_frames(blocks, {}).frame_by_frame);
  CHECK_THROWS_AS(compare_frames({}, {}), std::invalid_argument);
  blocks[0].base = {};
  CHECK_THROWS_AS(compare_frames(blocks, {}), std::invalid_argument);
  blocks[0].base = {0.0};
  CHECK_THROWS_AS(compare_frames(blocks, {}), std::invalid_argument);
}

TEST_CASE("a calibrated time is the same on a machine of another speed", "[gate][statistics]") {
  std::vector<CalibratedRun> runs;
  for (const double speed : {1.0, 3.0, 0.5}) {
    RunTimes frames(100);
    for (std::size_t k = 0; k < frames.size(); ++k) frames[k] = speed * static_cast<double>(k + 1);
    runs.push_back({frames, speed * 4.0});
  }
  CHECK(calibrated_time(runs, 99).ratio == Approx(99.0 / 4.0));
  CHECK(calibrated_time(runs, 50).ratio == Approx(50.0 / 4.0));
  runs[1].frames[98] *= 100.0;  // of one run only
  CHECK(calibrated_time(runs, 99).ratio == Approx(99.0 / 4.0));
  CHECK(calibrated_time(runs, 99).high > 24.9);
  runs[2].frames.pop_back();
  CHECK_THROWS_AS(calibrated_time(runs, 99), std::invalid_argument);
  CHECK_THROWS_AS(calibrated_time({}, 99), std::invalid_argument);
}

TEST_CASE("the calibration kernel does the same work each time", "[gate]") {
  CalibrationKernel one, other;
  const double result = one.frame();
  CHECK(std::isfinite(result));
  CHECK(one.frame() == result);
  CHECK(other.frame() == result);
  const KernelTime time = one.measure(10);
  CHECK(time.processor_ms > 0.0);
  CHECK(time.processor_ms <= 1.2 * time.wall_ms);  // one thread; medians of few need not be of the same frame
}
