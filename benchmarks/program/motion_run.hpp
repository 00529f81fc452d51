#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"
#include "core/insertion_frame.hpp"
#include "core/scene/scene.hpp"
#include "verification/studies/popping.hpp"

namespace finegauge {

/// One frame of a moving scene: a row of the result.
struct MotionFrame {
  InsertionReport report;                        ///< without a needle only `report.frame` is filled
  double frame_ms = 0.0;                         ///< wall time of the whole frame; its stages are in the report
  std::optional<std::int64_t> heap_allocations;  ///< within the frame (allocation_counter.hpp)
  Json quantities = Json::object();              ///< of interest, by name: displacements [x, y, z] and energies

  /// A frame like most of an interactive run: the mesh stays and the contact goes on as before.
  bool quiet() const { return report.frame.refined == 0 && report.frame.coarsened == 0 && report.events.empty(); }
};

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
MotionRun run_motion(const Scene& scene, const MotionObserver& observer);

}  // namespace finegauge
