#pragma once

#include <time.h>

namespace finegauge {

/// Processor time that this process has used so far, all its threads together [ms]. Differences of it are what work
/// took, whoever else the processor served in between: on a busy machine wall time measures the others.
inline double processor_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

}  // namespace finegauge
