#include "benchmarks/profile/processor_clock.hpp"

#include <algorithm>
#include <cstddef>
#include <ctime>

namespace finegauge {

StageClock processor_clock() {
  return {[](void*) -> std::int64_t {
            std::timespec now{};
            ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
            return std::int64_t{1000000000} * now.tv_sec + now.tv_nsec;
          },
          nullptr};
}

double median_ms(std::vector<double> times) {
  if (times.empty()) return 0.0;
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

}  // namespace finegauge
