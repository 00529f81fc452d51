#pragma once

#include "benchmarks/program/study.hpp"

namespace finegauge {

/// The paper's section "Impact of local mesh refinement on displacement field": how far friction drags the tissue along
/// a vertical line through the needle's tip, on the unrefined mesh, refined by 2×3×3 and by 3×3×3 where the error is,
/// and refined everywhere. --quick: half of the insertion.
StudyResult displacement_field_study(const StudyContext& context);

}  // namespace finegauge
