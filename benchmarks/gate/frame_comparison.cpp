#include "benchmarks/gate/frame_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "benchmarks/program/frame_statistics.hpp"

namespace finegauge {
namespace {

void require_times(const RunTimes& frames) {
  if (frames.empty()) throw std::invalid_argument("a run without frames");
  for (const double time : frames)
    if (!(time > 0.0 && std::isfinite(time))) throw std::invalid_argument("a frame's time is not positive");
}

std::vector<double> medians_of_frames(std::span<const RunTimes> runs) {
  std::vector<double> medians(runs.front().size());
  std::vector<double> of_frame(runs.size());
  for (std::size_t k = 0; k < medians.size(); ++k) {
    for (std::size_t r = 0; r < runs.size(); ++r) of_frame[r] = runs[r][k];
    medians[k] = median(of_frame);
  }
  return medians;
}

double log_ratio(const TimeBlock& block, const std::vector<int>& frames) {
  std::vector<double> ratios;
  ratios.reserve(frames.size());
  for (const int k : frames) ratios.push_back(std::log(block.head[k] / block.base[k]));
  return median(std::move(ratios));
}

}  // namespace

std::vector<int> frames_at_percentile(std::span<const RunTimes> runs, int percent) {
  const std::vector<double> medians = medians_of_frames(runs);
  const double bound = percentile(medians, percent);
  std::vector<int> frames;
  for (std::size_t k = 0; k < medians.size(); ++k)
    if (medians[k] >= bound) frames.push_back(static_cast<int>(k));
  return frames;
}

FrameComparison compare_frames(std::span<const TimeBlock> blocks, const ComparisonRule& rule) {
  if (blocks.empty()) throw std::invalid_argument("no blocks");
  FrameComparison comparison;
  comparison.blocks = static_cast<int>(blocks.size());
  const std::size_t count = blocks.front().head.size();
  std::vector<RunTimes> runs;
  for (const TimeBlock& block : blocks)
    for (const RunTimes& run : {block.head, block.base}) {
      require_times(run);
      comparison.frame_by_frame = comparison.frame_by_frame && run.size() == count;
      runs.push_back(run);
    }
  std::vector<double> differences;
  if (comparison.frame_by_frame) {
    const std::vector<int> frames = frames_at_percentile(runs, rule.percentile);
    for (const TimeBlock& block : blocks) differences.push_back(log_ratio(block, frames));
  } else {
    for (const TimeBlock& block : blocks)
      differences.push_back(
          std::log(percentile(block.head, rule.percentile) / percentile(block.base, rule.percentile)));
  }
  const HodgesLehmann shift = hodges_lehmann(differences, rule.confidence);
  comparison.ratio = std::exp(shift.shift);
  comparison.low = std::exp(shift.low);
  comparison.high = std::exp(shift.high);
  comparison.p_value = p_value_above(differences);
  comparison.alarm = comparison.p_value < rule.significance && comparison.ratio > 1.0 + rule.slower;
  // Noise so wide that a shift of the allowed size cannot be told from none. An alarm has been told.
  comparison.decided = comparison.alarm || 0.5 * (shift.high - shift.low) < std::log1p(rule.slower);
  return comparison;
}

bool wants_more_blocks(const FrameComparison& so_far, const ComparisonRule& rule) {
  if (so_far.blocks < rule.least_blocks) return true;
  if (so_far.blocks >= rule.most_blocks) return false;
  return 0.5 * std::log(so_far.high / so_far.low) > rule.interval;
}

CalibratedTime calibrated_time(std::span<const CalibratedRun> runs, int percent) {
  if (runs.empty()) throw std::invalid_argument("no runs");
  std::vector<RunTimes> scaled;
  CalibratedTime time;
  for (const CalibratedRun& run : runs) {
    require_times(run.frames);
    require_times({run.kernel_ms});
    if (run.frames.size() != runs.front().frames.size())
      throw std::invalid_argument("runs of one build differ in their number of frames");
    RunTimes frames = run.frames;
    for (double& frame : frames) frame /= run.kernel_ms;
    const double of_run = percentile(frames, percent);
    time.low = scaled.empty() ? of_run : std::min(time.low, of_run);
    time.high = std::max(time.high, of_run);
    scaled.push_back(std::move(frames));
  }
  time.ratio = percentile(medians_of_frames(scaled), percent);
  return time;
}

}  // namespace finegauge
