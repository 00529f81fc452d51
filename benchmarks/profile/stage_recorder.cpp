#include "benchmarks/profile/stage_recorder.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include "benchmarks/program/allocation_counter.hpp"

namespace finegauge {
namespace {

using enum FrameStage;

/// The stages in their order; none: time that the frame gives to no stage, because another timer has it.
std::vector<std::optional<FrameStage>> order_of_stages(const FrameReport& report, bool needle, std::size_t readings) {
  std::vector<std::optional<FrameStage>> order;
  if (needle) order.push_back(contact);
  for (int k = 0; k < report.newton_iterations; ++k)
    if (needle)
      order.insert(order.end(), {assemble, FrameStage::needle, solve, update});
    else
      order.insert(order.end(), {assemble, solve});
  order.push_back(update);
  if (needle) order.insert(order.end(), {contact, update});
  // From here on a second timer, started at once: the stretch up to its start is no stage's. It exists where the error
  // is estimated, and its stages are as many as there are readings for, but for the last two of the first timer.
  const std::size_t first_timer = order.size() + 1 + 2;
  if (readings > first_timer) {
    order.push_back(std::nullopt);
    const FrameStage second[] = {estimate, mark, topology, transfer};
    for (std::size_t k = 0; k < std::size(second) && first_timer + 1 + k < readings; ++k) order.push_back(second[k]);
  }
  order.push_back(std::nullopt);
  order.push_back(update);
  return order;
}

}  // namespace

StageRecorder::StageRecorder() {
  readings_.reserve(4096);  // more than any frame has: recording allocates nothing
}

std::int64_t StageRecorder::read(void* recorder) {
  const std::int64_t now = wall_nanoseconds(nullptr);
  static_cast<StageRecorder*>(recorder)->readings_.push_back({now, heap_allocations().value_or(0)});
  return now;
}

std::optional<std::vector<StageLap>> stage_laps(const std::vector<StageReading>& readings, const FrameReport& report,
                                                bool needle) {
  const std::vector<std::optional<FrameStage>> order = order_of_stages(report, needle, readings.size());
  if (readings.size() != order.size() + 1) return std::nullopt;
  std::vector<StageLap> laps;
  std::array<std::int64_t, frame_stage_count> sums{};
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (!order[k]) continue;
    const StageReading &a = readings[k], &b = readings[k + 1];
    laps.push_back({*order[k], a.nanoseconds, b.nanoseconds, b.allocations - a.allocations});
    sums[static_cast<std::size_t>(*order[k])] += b.nanoseconds - a.nanoseconds;
  }
  for (std::size_t stage = 0; stage < sums.size(); ++stage)
    if (std::llround(1e6 * (report.times.*frame_stages[stage].time)) != sums[stage]) return std::nullopt;
  return laps;
}

}  // namespace finegauge
