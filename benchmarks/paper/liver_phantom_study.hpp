#pragma once

#include "benchmarks/program/study.hpp"

namespace finegauge {

/// The paper's liver phantom: a needle goes in 4 cm and comes out again, the force over the travel of the tip being a
/// loop, on a coarse mesh, on a fine one that is nested in it, and adaptively from the coarse in halves and in thirds.
/// --quick: the first third of the frames.
StudyResult liver_phantom_study(const StudyContext& context);

}  // namespace finegauge
