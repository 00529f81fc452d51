#pragma once

#include "benchmarks/program/motion_run.hpp"
#include "benchmarks/program/result_document.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// Of a frame: by what factor its tolerance is missed (tolerance_ratio), at_rest, and what limits refinement (limit).
void put_tolerance(const Scene& scene, const FrameReport& frame, Json& row);

/// For which frames the tolerance was met, and by how much it was missed; of a body at rest none is asked.
Json tolerance_summary(const Scene& scene, const MotionRun& run);

/// What changes of the mesh did: how many, how many of them taken back, and what the force did beyond what the new
/// meshes' equilibria ask for, over the largest force of the run.
Json popping_summary(const Scene& scene, const MotionRun& run);

}  // namespace finegauge
