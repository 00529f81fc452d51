#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/gate/rank_statistics.hpp"

namespace finegauge {

/// Judging frame times without trusting a clock from another day. A run is the times of its frames [ms], in order.
///
/// Frame k of a scene does the same work in every run of it. So what a percentile stands for is found first: the frames
/// not faster than that percentile by their medians over all runs, which an interruption of single runs cannot move.
/// For 99 and 200 frames these are three, for 50 the slower half.
using RunTimes = std::vector<double>;

/// The frames, ascending, whose median over the runs is not below the percentile (nearest rank) of the medians. All
/// runs have as many frames, one or more (precondition); percentile: 1 to 100.
std::vector<int> frames_at_percentile(std::span<const RunTimes> runs, int percentile);

/// A run of either build right after the other, the order tossed.
struct TimeBlock {
  RunTimes head, base;
};

/// What is asked of a comparison of builds.
struct ComparisonRule {
  int percentile = 99;
  double slower = 0.10;        ///< allowed: the effect that is no alarm yet, as a fraction of the base's time
  double significance = 0.01;  ///< of the rank test, one-sided
  double confidence = 0.95;    ///< of the interval that is told
  int least_blocks = 12;       ///< of 7 or more, or the test cannot reach its significance
  int most_blocks = 40;
  double interval = 0.03;  ///< half of the interval's width in logarithms below which no more blocks are run
};

struct FrameComparison {
  double ratio = 1.0, low = 1.0, high = 1.0;  ///< head's over base's time: Hodges-Lehmann over blocks, in logarithms
  double p_value = 1.0;                       ///< that the head is not slower, Wilcoxon signed ranks over blocks
  int blocks = 0;
  bool frame_by_frame = true;  ///< false: the builds make different numbers of frames, percentiles of runs are compared
  bool alarm = false;          ///< slower by the test and by the effect
  bool decided = true;         ///< false: the noise hides the effect that is asked for, so nothing was compared
};
/// Each block counts once, by the median over the frames in question of log(head / base). Throws std::invalid_argument
/// without blocks, without frames, or where a time is not positive.
FrameComparison compare_frames(std::span<const TimeBlock> blocks, const ComparisonRule& rule);
/// Whether more blocks are asked for. Depends on how many there are and on how they scatter, not on which side they
/// are: a test that stops when it likes what it sees is none.
bool wants_more_blocks(const FrameComparison& so_far, const ComparisonRule& rule);

/// A run between two runs of the calibration kernel.
struct CalibratedRun {
  RunTimes frames;
  double kernel_ms = 0.0;  ///< a miniature frame then (calibration_kernel.hpp)
};
struct CalibratedTime {
  double ratio = 0.0;            ///< time of the percentile's frame over that of a miniature frame
  double low = 0.0, high = 0.0;  ///< the least and the most that one run had
};
/// The percentile over the frames of each frame's median over the runs, each in units of its run's miniature frame.
/// Throws std::invalid_argument where runs differ in their number of frames, have none, or a time is not positive.
CalibratedTime calibrated_time(std::span<const CalibratedRun> runs, int percentile);

}  // namespace finegauge
