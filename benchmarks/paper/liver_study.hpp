#pragma once

#include "benchmarks/program/study.hpp"

namespace finegauge {

/// The paper's section "Application to liver": a liver that breathes, a needle that goes in 4 cm and comes out again,
/// on the unrefined mesh and on one that holds a tolerance. --quick: the first third of the frames.
StudyResult liver_study(const StudyContext& context);

}  // namespace finegauge
