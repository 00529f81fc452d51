#pragma once

#include "benchmarks/program/study.hpp"

namespace finegauge {

/// The paper's section "Impact of local mesh refinement on needle-tissue interaction": puncture strengths 0, 10, 20 N
/// at friction 0.5 and frictions 0.1, 0.3, 0.5 at 10 N, on the coarse mesh, the paper's fine one (20×10×10 nodes, not
/// nested in the coarse), the nested fine one (19×9×9) and adaptively from the coarse. --quick: 10 N and 0.5 alone,
/// without the paper's fine mesh, over half of the insertion.
StudyResult phantom_study(const StudyContext& context);

}  // namespace finegauge
