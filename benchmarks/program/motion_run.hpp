#pragma once

#include <functional>
#include <string>
#include <vector>

#include "benchmarks/program/moving_simulation.hpp"

namespace finegauge {

/// What an observer sees after each frame. The tissue's mesh may already be that of the next frame.
struct MotionView {
  const MotionFrame& frame;
  const Tissue& tissue;
  const Insertion* insertion;  ///< none without a needle
  int frames;                  ///< planned
  bool last;                   ///< no further frame follows, unless the observer is what stops it
};
using MotionObserver = std::function<bool(const MotionView&)>;  ///< false: stop here

struct MotionRun {
  std::vector<MotionFrame> frames;
  int planned_frames = 0;  ///< of the scene's duration
  std::string stopped_because;
  bool failed = false;                      ///< a frame could not be computed; `stopped_because` says why
  double buckling_load = 0.0;               ///< of the free needle [N] (needle_drive.hpp); zero without a needle
  std::vector<double> final_state;          ///< insertion_frame.hpp, state_values
  std::vector<CheckedChange> mesh_changes;  ///< of a scene that asks for check_popping
  std::vector<std::string> notes;           ///< what a reader of the result should know of the problem
};

/// Frame by frame from rest. A frame that does not converge is marked, and the run goes on. Throws SceneError, before
/// the first frame, when a quantity's point is not in the body or the needle starts in it.
MotionRun run_motion(const Scene& scene, const MotionObserver& observer, StageClock stage_clock = {});

}  // namespace finegauge
