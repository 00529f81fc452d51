#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "benchmarks/profile/frame_stages.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {

/// What a frame's stage timer reads when it is recorded.
struct StageReading {
  std::int64_t nanoseconds = 0;
  std::int64_t allocations = 0;  ///< heap blocks so far (allocation_counter.hpp); zero where they cannot be counted
};

/// Keeps every reading of the stage timer, to draw the stages where they were and to count what they allocated.
class StageRecorder {
 public:
  StageRecorder();
  StageRecorder(const StageRecorder&) = delete;  // the clock points here
  StageRecorder& operator=(const StageRecorder&) = delete;

  /// To be read while this exists.
  StageClock clock() { return {&read, this}; }
  const std::vector<StageReading>& readings() const { return readings_; }
  void clear() { readings_.clear(); }

 private:
  static std::int64_t read(void* recorder);
  std::vector<StageReading> readings_;
};

/// A stretch of a frame between two readings.
struct StageLap {
  FrameStage stage;
  std::int64_t begin, end;  ///< [ns]
  std::int64_t allocations;
};

/// Which stage each pair of readings belongs to, by the order in which a frame goes through its stages
/// (core/insertion_frame.cpp, core/tissue_frame.cpp). None where the laps do not sum to the frame's own times, to the
/// nanosecond: the order here is then no longer the core's.
std::optional<std::vector<StageLap>> stage_laps(const std::vector<StageReading>& readings, const FrameReport& report,
                                                bool needle);

}  // namespace finegauge
