#pragma once

#include <span>
#include <vector>

namespace finegauge {

/// How long frames took, and how often one was late. Times in one unit of the caller's, in the order of the frames.
/// All of it throws std::invalid_argument where there is no time at all, and on a time that is negative or not finite:
/// a run that measured nothing has no statistics.

/// The nearest-rank percentile: the smallest of the times that at least `percent` % of them do not exceed, number
/// ceil(percent n / 100) in ascending order. It is one of the times, never a mean of two, and the rank is found in
/// integers. Of fewer than 100 frames the 99th percentile is the maximum. percent: 1 to 100.
double percentile(std::span<const double> times, int percent);

struct FrameStatistics {
  double p50, p95, p99, max;
};
FrameStatistics frame_times(std::span<const double> times);

struct DeadlineMisses {
  int missed = 0;          ///< frames that took longer than the deadline; as long as the deadline is in time
  int longest_streak = 0;  ///< most of them in a row: what a user feels as a stutter
};
/// deadline > 0.
DeadlineMisses deadline_misses(std::span<const double> times, double deadline);

struct StageStatistics {
  double p50, p99;
};
/// For each stage; times: frame after frame, in each the stages in their order. A stage's percentiles are its own: they
/// need not come from one frame, and those of the stages do not sum to the frame's.
std::vector<StageStatistics> stage_times(std::span<const double> times, int stages);

}  // namespace finegauge
