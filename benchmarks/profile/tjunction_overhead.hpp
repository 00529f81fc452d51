#pragma once

#include <vector>

#include "benchmarks/profile/tjunction_ledger.hpp"
#include "benchmarks/program/motion_run.hpp"

namespace finegauge {

/// What hanging nodes cost a moving scene, frame by frame. All times are the processor's [ms], so that the parts and
/// the frames are of one clock. The parts are timed between frames, on every mesh that the scene comes by
/// (time_tjunctions), and counted as often as a frame does them.
struct TjunctionFrame {
  double frame_ms = 0.0;   ///< all stages
  double build_ms = 0.0;   ///< T of the mesh that the frame ended with; zero where the mesh stayed
  double reduce_ms = 0.0;  ///< assemblies × TjunctionTimes::reduce_ms
  double expand_ms = 0.0;  ///< fields to all nodes and forces to the masters
  int hanging_nodes = 0;   ///< of the mesh that the frame was solved on

  double overhead_ms() const { return build_ms + reduce_ms + expand_ms; }
};

/// Collects them; hand `observe` the frames of a run with processor_clock().
class TjunctionOverhead {
 public:
  explicit TjunctionOverhead(int repetitions) : repetitions_(repetitions) {}
  void observe(const MotionView& view);

  const std::vector<TjunctionFrame>& frames() const { return frames_; }
  int meshes() const { return meshes_; }

 private:
  int repetitions_;
  int meshes_ = 0;
  TjunctionTimes times_;  // of the mesh that the last frame ended with
  std::vector<TjunctionFrame> frames_;
};

/// Shares of the frames' time, all frames together: what a user waits for. `frames_with_hanging_nodes` alone beside it,
/// and the percentiles over those frames.
Json overhead_summary(const TjunctionOverhead& overhead);
/// The share of all frames' time, parts together.
double overhead_share(const TjunctionOverhead& overhead);

}  // namespace finegauge
