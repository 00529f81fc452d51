#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "benchmarks/program/result_document.hpp"
#include "core/insertion_frame.hpp"
#include "core/mesh/point_location.hpp"
#include "core/scene/scene.hpp"
#include "verification/studies/popping.hpp"

namespace finegauge {

/// One frame of a moving scene: a row of the result.
struct MotionFrame {
  InsertionReport report;                        ///< without a needle only `report.frame` is filled
  double frame_ms = 0.0;                         ///< wall time of the whole frame; its stages are in the report
  double processor_ms = 0.0;                     ///< what it took of the processor: without what others did meanwhile
  std::optional<std::int64_t> heap_allocations;  ///< within the frame (allocation_counter.hpp)
  Json quantities = Json::object();              ///< of interest, by name: displacements [x, y, z] and energies

  /// A frame like most of an interactive run: the mesh stays and the contact goes on as before.
  bool quiet() const { return report.frame.refined == 0 && report.frame.coarsened == 0 && report.events.empty(); }
};

/// A moving scene, frame by frame from rest: for who wants to advance several of them in turns.
class MovingSimulation {
 public:
  /// `scene` must have dynamics and outlive the simulation. Throws SceneError when a quantity's point is not in the
  /// body or the needle starts in it.
  explicit MovingSimulation(const Scene& scene, StageClock stage_clock = {});

  /// Throws what a frame throws that cannot be computed; one that does not converge is told in its report.
  MotionFrame advance();

  int planned_frames() const { return planned_frames_; }  ///< of the scene's duration
  const Scene& scene() const { return scene_; }
  const Tissue& tissue() const;        ///< its mesh may already be that of the next frame
  const Insertion* insertion() const;  ///< none without a needle
  double buckling_load() const;        ///< of the free needle [N] (needle_drive.hpp); zero without a needle
  std::vector<double> state() const;   ///< insertion_frame.hpp, state_values
  const std::vector<CheckedChange>& mesh_changes() const { return mesh_changes_; }  ///< of check_popping

 private:
  /// Without a needle.
  struct FreeMotion {
    MotionProblem problem;
    Tissue tissue;
    EnergyLedger energy;
  };
  struct NeedleMotion {
    InsertionProblem problem;
    Insertion insertion;
  };
  using Motion = std::variant<FreeMotion, NeedleMotion>;

  static Motion start(const Scene& scene, StageClock stage_clock);
  Json frame_quantities() const;

  const Scene& scene_;
  Motion motion_;
  std::vector<std::optional<MaterialPoint>> points_;  ///< of the quantities
  int planned_frames_;
  std::vector<CheckedChange> mesh_changes_;
};

}  // namespace finegauge
