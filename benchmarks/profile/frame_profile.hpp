#pragma once

#include <optional>
#include <string>
#include <vector>

#include "benchmarks/measure/calibration.hpp"
#include "benchmarks/profile/stage_recorder.hpp"
#include "benchmarks/profile/stage_work.hpp"
#include "benchmarks/profile/trace_events.hpp"
#include "benchmarks/program/motion_run.hpp"
#include "benchmarks/program/static_run.hpp"

namespace finegauge {

/// One stage over all frames, or steps of a static scene.
struct ProfileStage {
  std::string name;
  std::vector<double> ms;                          ///< per frame
  std::optional<std::vector<double>> allocations;  ///< per frame, where they can be counted
  std::vector<StageWork> work;                     ///< per frame whose sizes are known; empty: nothing is counted
  std::vector<double> worked_ms;                   ///< time of each of those frames
};

/// Gathers a run's stages, work and trace while it goes on.
class FrameProfile {
 public:
  FrameProfile(const Scene& scene, StageRecorder* recorder);
  /// A moving scene's frame; the recorder has its readings, and is cleared.
  void add(const MotionView& view);
  /// A static scene's step.
  void add(const StaticView& view);

  /// The stages that took time, and `other`: what no stage has. The shares sum to one.
  const std::vector<ProfileStage>& stages() const { return stages_; }
  const TraceEvents& trace() const { return trace_; }
  /// Whether every frame's stages could be told apart in the recorder's readings.
  bool laps_known() const { return laps_known_; }
  const std::vector<double>& frame_ms() const { return frame_ms_; }

 private:
  void add_work(const std::string& stage, const StageWork& work, double ms);
  ProfileStage& stage(const std::string& name);

  const Scene& scene_;
  StageRecorder* recorder_;
  std::vector<ProfileStage> stages_;
  std::vector<double> frame_ms_;
  TraceEvents trace_;
  bool laps_known_ = true;
  std::optional<WorkSizes> sizes_;  ///< of the mesh that the next frame is solved on
  int factorizations_ = 0, columns_ = 0;
  std::int64_t static_clock_ = 0;
};

/// The result's rows: stage, p50_ms, p99_ms, share, allocations, flops and bytes with the rates that they reach and the
/// fraction of the machine's.
Json profile_rows(const FrameProfile& profile, const MachineRates& machine);
Json to_json(const MachineRates& machine);

}  // namespace finegauge
