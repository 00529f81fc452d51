#pragma once

#include <string>
#include <vector>

#include "benchmarks/program/motion_run.hpp"
#include "benchmarks/program/result_document.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// The row of a frame; what the scene does not have is null with a reason beside it (KEY_reason).
Json to_json(const MotionFrame& frame, const Scene& scene);

/// The summary of a run of at least one frame.
Json summarize(const Scene& scene, const MotionRun& run);

/// Checks: every frame converged, and none is missing unless the user ended the run.
Json motion_checks(const MotionRun& run, bool ended_by_user);

/// "3 of 500 frames did not converge, the first is frame 12 (t = 0.06 s): ..."; empty when all did.
std::string convergence_failure(const MotionRun& run);

/// The energies' imbalance over the largest sum of energies that a frame has seen; zero when there was none.
double relative_closure(const MotionRun& run);

/// Notes that only the finished run can give: of its problem, of buckling.
std::vector<std::string> run_notes(const Scene& scene, const MotionRun& run);

}  // namespace finegauge
