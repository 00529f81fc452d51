#pragma once

#include "benchmarks/paper/lshape_run.hpp"
#include "benchmarks/program/study.hpp"

namespace finegauge {

struct LshapeStudyOptions {
  LshapeRunOptions run;
  bool default_problem = true;  ///< the one whose exact energy is known
};
/// From the keys of --set (lshape_study.hpp). Throws UsageError for a key that is unknown or a value out of range.
LshapeStudyOptions read_lshape_options(const StudyContext& context);

}  // namespace finegauge
