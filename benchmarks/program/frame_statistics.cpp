#include "benchmarks/program/frame_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace finegauge {

namespace {

void check_times(std::span<const double> times) {
  if (times.empty()) throw std::invalid_argument("times: found none, allowed is one or more");
  for (std::size_t k = 0; k < times.size(); ++k)
    if (!(times[k] >= 0.0 && std::isfinite(times[k])))
      throw std::invalid_argument("time " + std::to_string(k) + ": found " + std::to_string(times[k]) +
                                  ", allowed is finite and >= 0");
}

double ranked(const std::vector<double>& ascending, int percent) {
  const std::size_t rank = (static_cast<std::size_t>(percent) * ascending.size() + 99) / 100;
  return ascending[rank - 1];
}

std::vector<double> ascending_copy(std::span<const double> times) {
  check_times(times);
  std::vector<double> ascending(times.begin(), times.end());
  std::sort(ascending.begin(), ascending.end());
  return ascending;
}

}  // namespace

double percentile(std::span<const double> times, int percent) {
  if (!(percent >= 1 && percent <= 100))
    throw std::invalid_argument("percent: found " + std::to_string(percent) + ", allowed is 1 to 100");
  return ranked(ascending_copy(times), percent);
}

FrameStatistics frame_times(std::span<const double> times) {
  const std::vector<double> ascending = ascending_copy(times);
  return {ranked(ascending, 50), ranked(ascending, 95), ranked(ascending, 99), ascending.back()};
}

DeadlineMisses deadline_misses(std::span<const double> times, double deadline) {
  check_times(times);
  if (!(deadline > 0.0 && std::isfinite(deadline)))
    throw std::invalid_argument("deadline: found " + std::to_string(deadline) + ", allowed is finite and > 0");
  DeadlineMisses misses;
  int streak = 0;
  for (const double time : times) {
    streak = time > deadline ? streak + 1 : 0;
    misses.missed += streak > 0;
    misses.longest_streak = std::max(misses.longest_streak, streak);
  }
  return misses;
}

std::vector<StageStatistics> stage_times(std::span<const double> times, int stages) {
  if (!(stages >= 1 && times.size() % static_cast<std::size_t>(stages) == 0))
    throw std::invalid_argument("stages: found " + std::to_string(stages) + " for " + std::to_string(times.size()) +
                                " times, allowed is a divisor >= 1");
  const std::size_t stage_count = static_cast<std::size_t>(stages);
  std::vector<StageStatistics> result;
  std::vector<double> of_stage(times.size() / stage_count);
  for (std::size_t stage = 0; stage < stage_count; ++stage) {
    for (std::size_t frame = 0; frame < of_stage.size(); ++frame) of_stage[frame] = times[frame * stage_count + stage];
    const std::vector<double> ascending = ascending_copy(of_stage);
    result.push_back({ranked(ascending, 50), ranked(ascending, 99)});
  }
  return result;
}

}  // namespace finegauge
