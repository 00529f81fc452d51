#pragma once

#include "core/insertion_frame.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// Frames that cover the duration; the last one may end up to a time step after it.
int frame_count(const SceneDynamics& dynamics);

/// The needle at its start: straight from base to tip, or with the imperfection that grows with the square of the
/// distance from the base; rest is then the curved shape.
Needle scene_needle(const SceneNeedle& needle);

/// The problems that a scene with [dynamics], and one with [needle], stands for.
MotionProblem motion_problem(const Scene& scene);
InsertionProblem insertion_problem(const Scene& scene);

}  // namespace finegauge
