#pragma once

#include <string>
#include <utility>
#include <vector>

#include "benchmarks/program/motion_run.hpp"
#include "benchmarks/program/section.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// What is drawn of a frame beside the insertion's state.
struct SectionMoment {
  std::string stage;                 ///< start, depth or end
  double depth = 0.0;                ///< inserted length [m]
  double largest_energy_norm = 0.0;  ///< of the tissue so far [√J]
};

/// When a run with a needle is drawn, each stage once: `start`, its first frame; `depth`, the frame in which the base
/// has gone farthest along the needle's axis; `end`, its last frame. A run that ends before its full depth has `depth`
/// in its last frame, too. To be told of every frame.
class NeedleSections {
 public:
  explicit NeedleSections(const Scene& scene);
  std::vector<SectionMoment> moments_of(const MotionView& view, bool last);

 private:
  int deepest_frame_ = 0;
  bool started_ = false, deepest_drawn_ = false;
  double largest_energy_norm_ = 0.0;
};

/// Two pictures of the body cut open along the needle as it was at the start, with z upwards (y for a needle along z):
/// SCENE_STAGE_stress.svg with the von Mises stress at the cells' centres, and SCENE_STAGE_eta.svg with η_e over the
/// largest energy norm so far, so that the stages compare; names and SVG. A body at rest (energy_at_rest) is drawn in
/// one colour: its stress and error are what a motion has left. `surface_points`: those of an immersed body's surface
/// (section.hpp), empty without one. `estimate` is of the insertion's mesh and state.
std::vector<std::pair<std::string, std::string>> section_pictures(const Scene& scene, const Insertion& insertion,
                                                                  const ErrorEstimate& estimate,
                                                                  const std::vector<MaterialPoint>& surface_points,
                                                                  const SectionMoment& moment);

}  // namespace finegauge
