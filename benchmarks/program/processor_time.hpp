#pragma once

#include <time.h>

namespace finegauge {

/// Processor time that the calling thread has used so far [ms]. Differences of it are what work took, whoever else the
/// processor served in between: on a busy machine wall time measures the others. Where threads share the work it waits
/// for the others without leaving its processor (OpenMP's default, for some milliseconds), so that it takes as long as
/// the slowest of them.
inline double processor_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

}  // namespace finegauge
