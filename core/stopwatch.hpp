#pragma once

#include <chrono>
#include <cstdint>

namespace finegauge {

inline std::int64_t wall_nanoseconds(void*) {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// What is read at the ends of a frame's stages: the wall clock, unless who runs the frames gives something else that
/// counts upwards, or wants to record the readings. Without a function nothing is read and every stage takes zero.
struct StageClock {
  std::int64_t (*read)(void* context) = &wall_nanoseconds;  ///< nanoseconds
  void* context = nullptr;                                  ///< handed to `read`
};
inline constexpr StageClock no_stage_clock = {nullptr, nullptr};

/// The stage timer, the only clock that the core reads.
class Stopwatch {
 public:
  explicit Stopwatch(StageClock clock = {}) : clock_(clock) {
    if (clock_.read) last_ = clock_.read(clock_.context);
  }
  /// Milliseconds since construction or the last lap.
  double lap() {
    if (!clock_.read) return 0.0;
    const std::int64_t now = clock_.read(clock_.context);
    const double ms = 1e-6 * static_cast<double>(now - last_);
    last_ = now;
    return ms;
  }

 private:
  StageClock clock_;
  std::int64_t last_ = 0;
};

}  // namespace finegauge
