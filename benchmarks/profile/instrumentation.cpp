#include "benchmarks/profile/instrumentation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "benchmarks/profile/processor_clock.hpp"
#include "benchmarks/profile/stage_recorder.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/start_forest.hpp"

namespace finegauge {
namespace {

/// A scene's body, with or without a needle, frame by frame.
class Motion {
 public:
  Motion(const Scene& scene, StageClock clock) {
    if (scene.needle) {
      insertion_problem_ = insertion_problem(scene);
      insertion_problem_->motion.stage_clock = clock;
      insertion_.emplace(start_insertion(start_forest(scene), *insertion_problem_));
    } else {
      problem_ = motion_problem(scene);
      problem_->stage_clock = clock;
      tissue_.emplace(start_tissue(start_forest(scene), *problem_));
    }
  }
  FrameReport advance() {
    return insertion_ ? advance_frame(*insertion_problem_, *insertion_).frame
                      : advance_frame(*problem_, *tissue_, energy_);
  }
  std::vector<double> state() const { return insertion_ ? state_values(*insertion_) : state_values(*tissue_); }

 private:
  std::optional<InsertionProblem> insertion_problem_;
  std::optional<Insertion> insertion_;
  std::optional<MotionProblem> problem_;
  std::optional<Tissue> tissue_;
  EnergyLedger energy_;
};

/// Nanoseconds of one call, the best of several rounds of many.
template <class Call>
double cost_ns(Call call) {
  constexpr int rounds = 20, calls = 1000;
  double best = INFINITY;
  for (int round = 0; round < rounds; ++round) {
    const std::int64_t start = wall_nanoseconds(nullptr);
    for (int i = 0; i < calls; ++i) call();
    best = std::min(best, static_cast<double>(wall_nanoseconds(nullptr) - start) / calls);
  }
  return best;
}

}  // namespace

Instrumentation measure_instrumentation(const Scene& scene, int frames) {
  Instrumentation result;
  StageRecorder recorder;
  const StageClock clock = recorder.clock();
  result.reading_ns = cost_ns([&, calls = 0]() mutable {
    clock.read(clock.context);
    if (++calls % 64 == 0) recorder.clear();  // as after a frame
  });
  volatile std::int64_t sink = 0;
  result.clock_ns = cost_ns([&] { sink = wall_nanoseconds(nullptr); });

  Motion on(scene, clock), off(scene, no_stage_clock);
  std::vector<double> on_ms, off_ms, ratios;
  double readings = 0.0;
  for (int i = 0; i < frames; ++i) {
    // By the processor's time, read outside of the frames of either kind.
    const auto advance = [&](Motion& motion, std::vector<double>& ms) {
      Stopwatch watch(processor_clock());
      const FrameReport report = motion.advance();
      ms.push_back(watch.lap());
      return report;
    };
    recorder.clear();
    if (i % 2 == 0) advance(on, on_ms);
    result.stage_ms_when_off += advance(off, off_ms).times.total();
    if (i % 2 != 0) advance(on, on_ms);
    readings += static_cast<double>(recorder.readings().size());
    ratios.push_back(on_ms.back() / off_ms.back() - 1.0);
  }
  result.frames = frames;
  result.readings_per_frame = readings / frames;
  result.frame_ms_on = median_ms(on_ms), result.frame_ms_off = median_ms(off_ms);
  result.same_states = on.state() == off.state();
  std::sort(ratios.begin(), ratios.end());
  const double half = 0.98 * std::sqrt(static_cast<double>(frames));  // 1.96 standard deviations of a fair coin's heads
  const auto at = [&](double rank) {
    return ratios[static_cast<std::size_t>(std::clamp(std::lround(rank), 0L, static_cast<long>(frames - 1)))];
  };
  result.paired = at(0.5 * frames), result.paired_low = at(0.5 * frames - half),
  result.paired_high = at(0.5 * frames + half);
  return result;
}

Json to_json(const Instrumentation& m) {
  return {{"frames", m.frames},
          {"readings_per_frame", m.readings_per_frame},
          {"reading_ns", m.reading_ns},
          {"clock_ns", m.clock_ns},
          {"frame_ms_on", m.frame_ms_on},
          {"frame_ms_off", m.frame_ms_off},
          {"share", m.share()},
          {"paired_difference", {{"median", m.paired}, {"low", m.paired_low}, {"high", m.paired_high}}},
          {"stage_ms_when_off", m.stage_ms_when_off},
          {"same_states", m.same_states}};
}

}  // namespace finegauge
