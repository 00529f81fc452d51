#pragma once

#include "benchmarks/program/study.hpp"

namespace finegauge {

/// The paper's convergence study and its Table 1: error over degrees of freedom on the L-shape for uniform refinement,
/// for the paper's adaptivity (2×2×2, maximum strategy, θ = 0.3) and for templates chosen by the direction of the
/// error; estimated and true errors, and the time of every stage, all with one solver in one run.
///
/// Keys of --set: notch (lower_left, lower_right, upper_left, upper_right), clamped, roller, loaded (surfaces),
/// theta, directional_theta. With another notch or other surfaces the exact energy is not known and true errors are
/// null.
StudyResult lshape_study(const StudyContext& context);

}  // namespace finegauge
