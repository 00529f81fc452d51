#include "benchmarks/profile/frame_profile.hpp"

#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "benchmarks/profile/instrumentation.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

Scene shipped_scene(const std::string& name) {
  return read_scene(std::string(FINEGAUGE_SOURCE_DIR) + "/reference_data/scenes/" + name + ".toml");
}

/// What the trace-event format demands of the events used here ("Trace Event Format", the Chromium project): empty, or
/// the first thing that is wrong.
std::string trace_error(const Json& document) {
  if (!document.is_object() || !document.contains("traceEvents") || !document["traceEvents"].is_array())
    return "no array traceEvents";
  if (document.contains("displayTimeUnit") && document["displayTimeUnit"] != "ms" &&
      document["displayTimeUnit"] != "ns")
    return "displayTimeUnit is neither ms nor ns";
  std::map<std::pair<int, int>, std::vector<std::pair<double, double>>> open;  // by process and thread: begin, end
  for (const Json& event : document["traceEvents"]) {
    const std::string where = event.dump();
    for (const char* key : {"name", "ph"})
      if (!event.contains(key) || !event[key].is_string()) return std::string("no text ") + key + " in " + where;
    for (const char* key : {"pid", "tid"})
      if (!event.contains(key) || !event[key].is_number_integer()) return std::string("no ") + key + " in " + where;
    const std::string phase = event["ph"];
    if (phase == "M") {
      if (!event.contains("args") || !event["args"]["name"].is_string()) return "metadata without a name: " + where;
      continue;
    }
    if (!event.contains("ts") || !event["ts"].is_number() || !(event["ts"].get<double>() >= 0.0)) return "ts: " + where;
    if (phase == "C") {
      if (!event.contains("args") || event["args"].empty()) return "counter without a series: " + where;
      for (const Json& value : event["args"])
        if (!value.is_number()) return "counter that is no number: " + where;
      continue;
    }
    if (phase != "X") return "phase " + phase;
    if (!event.contains("dur") || !event["dur"].is_number() || !(event["dur"].get<double>() >= 0.0))
      return "dur: " + where;
    // Complete events of a thread contain one another or lie apart; half a nanosecond of rounding.
    const double begin = event["ts"], end = begin + event["dur"].get<double>(), rounding = 5e-4;
    auto& stack = open[{event["pid"], event["tid"]}];
    while (!stack.empty() && stack.back().second <= begin + rounding) stack.pop_back();
    if (!stack.empty() && end > stack.back().second + rounding) return "overlaps the event around it: " + where;
    if (!stack.empty() && begin < stack.back().first - rounding) return "begins before the event around it: " + where;
    stack.emplace_back(begin, end);
  }
  return {};
}

}  // namespace

TEST_CASE("the stages of a frame are told apart in what the timer read", "[profile]") {
  for (const std::string name : {"phantom", "block_swing"}) {
    CAPTURE(name);
    const Scene scene = shipped_scene(name);
    StageRecorder recorder;
    int frames = 0, changed = 0;
    run_motion(
        scene,
        [&](const MotionView& view) {
          const FrameReport& report = view.frame.report.frame;
          const bool needle = view.insertion != nullptr;
          const auto laps = stage_laps(recorder.readings(), report, needle);
          REQUIRE(laps);
          std::int64_t last = 0, sum = 0, allocations = 0;
          for (const StageLap& lap : *laps) {
            CHECK(lap.begin >= last);
            CHECK(lap.end >= lap.begin);
            CHECK(lap.allocations >= 0);
            last = lap.end, sum += lap.end - lap.begin, allocations += lap.allocations;
          }
          CHECK_THAT(1e-6 * static_cast<double>(sum), WithinAbs(report.times.total(), 1e-9));
          if (view.frame.heap_allocations) CHECK(allocations <= *view.frame.heap_allocations);
          // Another order, or readings that are not the frame's, must not pass.
          CHECK_FALSE(stage_laps(recorder.readings(), report, !needle));
          std::vector<StageReading> shifted = recorder.readings();
          shifted[1].nanoseconds += 1;
          CHECK_FALSE(stage_laps(shifted, report, needle));
          changed += report.refined + report.coarsened > 0;
          recorder.clear();
          return ++frames < 40;
        },
        recorder.clock());
    CHECK(frames == 40);
    CHECK(changed > 0);  // topology and transfer were among the stages
  }
}

TEST_CASE("a profile's shares sum to one, and its trace is a trace", "[profile]") {
  const Scene scene = shipped_scene("phantom");
  StageRecorder recorder;
  FrameProfile profile(scene, &recorder);
  int frames = 0;
  run_motion(
      scene,
      [&](const MotionView& view) {
        profile.add(view);
        return ++frames < 30;
      },
      recorder.clock());
  CHECK(profile.laps_known());
  MachineRates machine;
  machine.bytes_per_second = 2e10, machine.fused_flops_per_second = 1e11;
  const Json rows = profile_rows(profile, machine);
  double shares = 0.0;
  std::vector<std::string> stages;
  for (const Json& row : rows) {
    shares += row["share"].get<double>();
    stages.push_back(row["stage"]);
    CHECK(row["p50_ms"].get<double>() <= row["p99_ms"].get<double>());
    for (const char* key : {"flops", "bytes"}) {
      const std::string rate = std::string(key) + "_per_second", fraction = std::string(key) + "_of_machine";
      if (row[rate].is_null()) {
        CHECK_FALSE(row[rate + "_reason"].get<std::string>().empty());
        continue;
      }
      const double whole = std::string(key) == "flops" ? 1e11 : 2e10;
      CHECK_THAT(row[fraction].get<double>(), WithinRel(row[rate].get<double>() / whole, 1e-12));
      CHECK(row[std::string(key) + "_per_frame"].get<double>() > 0.0);
    }
  }
  CHECK_THAT(shares, WithinAbs(1.0, 1e-12));
  CHECK(stages == std::vector<std::string>{"assemble", "needle", "contact", "solve", "update", "estimate", "mark",
                                           "topology", "transfer", "other"});

  const Json trace = Json::parse(profile.trace().text({{"scene", "phantom"}}));
  CHECK(trace_error(trace) == "");
  std::map<std::string, int> count;
  for (const Json& event : trace["traceEvents"])
    ++count[event["ph"].get<std::string>() + " " + event["name"].get<std::string>()];
  CHECK(count["X frame 1"] == 1);
  CHECK(count["X solve"] == 30);
  CHECK(count["C dofs"] == 30);
  CHECK(count["C hanging nodes"] == 30);

  // The rules find what is wrong.
  Json broken = trace;
  broken["traceEvents"][2]["dur"] = -1.0;
  CHECK(trace_error(broken) != "");
  broken = trace;
  broken["traceEvents"][3]["dur"] = 1e9;
  CHECK(trace_error(broken) != "");
  broken = trace;
  broken["traceEvents"][2].erase("ts");
  CHECK(trace_error(broken) != "");
}

TEST_CASE("a static scene is profiled by its steps", "[profile]") {
  Scene scene = shipped_scene("lshape");
  scene.adapt->max_dofs = 2000;
  FrameProfile profile(scene, nullptr);
  double reduce_and_assemble = 0.0;
  const StaticRun run = run_static(scene, [&](const StaticView& view) {
    profile.add(view);
    reduce_and_assemble += view.step.reduce_ms + view.step.assemble_ms;
    return true;
  });
  REQUIRE(run.steps.size() > 1);
  MachineRates machine;
  machine.bytes_per_second = 2e10, machine.fused_flops_per_second = 1e11;
  double shares = 0.0;
  for (const Json& row : profile_rows(profile, machine)) shares += row["share"].get<double>();
  CHECK_THAT(shares, WithinAbs(1.0, 1e-12));
  CHECK(reduce_and_assemble > 0.0);
  CHECK(trace_error(Json::parse(profile.trace().text(Json::object()))) == "");
}

TEST_CASE("stages cost nothing when nobody reads them, and next to nothing when somebody does", "[profile]") {
  const Instrumentation cost = measure_instrumentation(shipped_scene("phantom"), 30);
  CHECK(cost.same_states);
  CHECK(cost.stage_ms_when_off == 0.0);
  // Contact twice, the four stages of one linearization, update three times, estimate and mark, and the starts.
  CHECK(cost.readings_per_frame >= 14.0);
  CHECK(cost.readings_per_frame <= 16.0);
  CHECK(cost.reading_ns >= cost.clock_ns);
  CHECK(cost.share() > 1e-6);
  CHECK(cost.share() < 0.01);
  CHECK(cost.paired_low <= cost.paired);
  CHECK(cost.paired <= cost.paired_high);
}

TEST_CASE("work of one cell, by hand", "[profile]") {
  BoxMeshOptions box;
  const RefinementForest forest{box_mesh(box)};
  Material material;
  material.kinematics = Kinematics::corotational;
  const Discretization d = discretize(forest, material, {{"x_max", std::nullopt, {}}});
  const WorkSizes sizes = work_sizes(d, true);
  CHECK(sizes.cells == 1.0);
  CHECK(sizes.blocks == 64.0);
  CHECK(sizes.rows == 8.0);
  CHECK(sizes.hanging_entries == 0.0);
  CHECK(sizes.factor_nonzeros == 300.0);
  CHECK(sizes.factor_flops == 4900.0);
  // 64 blocks R K Rᵀ of two products of 45 flops, and 9 additions each.
  CHECK(static_assembly_work(sizes).flops == 64.0 * 90.0 + 64.0 * 9.0);
  // K v, 18 a block; 9 to scale it; the force: 8 vectors turned there and back, 24 differences, 24 rows of 47 flops.
  CHECK(assembly_work(sizes).flops - static_assembly_work(sizes).flops == 64.0 * 27.0 + 240.0 + 24.0 + 1128.0);
  // Three iterations, with the factor each: 18 a block and 10 for each of 24 unknowns, 4 a nonzero.
  CHECK(solve_work(sizes, {3.0, 0.0, 0.0, true}).flops == 3.0 * (18.0 * 64.0 + 240.0 + 4.0 * 300.0));
  CHECK(solve_work(sizes, {0.0, 2.0, 6.0, true}).flops == 2.0 * 4900.0 + 6.0 * 1200.0);
  CHECK(solve_work(sizes, {3.0, 0.0, 0.0, false}).flops == 3.0 * (18.0 * 64.0 + 240.0));
}
