#include "benchmarks/profile/frame_profile.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "benchmarks/program/allocation_counter.hpp"
#include "benchmarks/program/frame_statistics.hpp"
#include "benchmarks/program/optional_field.hpp"
#include "core/scene/attachments.hpp"

namespace finegauge {
namespace {

constexpr std::pair<const char*, double StaticStep::*> static_stages[] = {
    {"topology", &StaticStep::topology_ms}, {"assemble", &StaticStep::assemble_ms}, {"reduce", &StaticStep::reduce_ms},
    {"solve", &StaticStep::solve_ms},       {"estimate", &StaticStep::estimate_ms}, {"mark", &StaticStep::mark_ms}};

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

std::int64_t nanoseconds(double ms) { return std::llround(1e6 * ms); }

}  // namespace

FrameProfile::FrameProfile(const Scene& scene, StageRecorder* recorder)
    : scene_(scene), recorder_(recorder), trace_("finegauge " + scene.name) {
  if (scene.dynamics)
    for (const NamedStage& named : frame_stages) stages_.push_back({named.name, {}, {}, {}, {}});
  else
    for (const auto& [name, member] : static_stages) stages_.push_back({name, {}, {}, {}, {}});
  stages_.push_back({"other", {}, {}, {}, {}});
}

ProfileStage& FrameProfile::stage(const std::string& name) {
  return *std::ranges::find(stages_, name, &ProfileStage::name);
}

void FrameProfile::add_work(const std::string& name, const StageWork& work, double ms) {
  ProfileStage& found = stage(name);
  found.work.push_back(work);
  found.worked_ms.push_back(ms);
}

void FrameProfile::add(const MotionView& view) {
  const FrameReport& report = view.frame.report.frame;
  frame_ms_.push_back(view.frame.frame_ms);
  for (int k = 0; k < frame_stage_count; ++k)
    stages_[static_cast<std::size_t>(k)].ms.push_back(report.times.*frame_stages[static_cast<std::size_t>(k)].time);
  stages_.back().ms.push_back(std::max(0.0, view.frame.frame_ms - report.times.total()));

  const std::vector<StageReading>& readings = recorder_->readings();
  const auto laps = stage_laps(readings, report, view.insertion != nullptr);
  if (laps) {
    const std::int64_t begin = readings.front().nanoseconds, end = readings.back().nanoseconds;
    trace_.add_span("frame " + std::to_string(report.frame), begin, end,
                    {{"time_s", report.time},
                     {"dofs", report.dofs},
                     {"cells", report.cells},
                     {"solver_iterations", report.solver_iterations},
                     {"refined", report.refined},
                     {"coarsened", report.coarsened}});
    std::vector<double> allocations(frame_stage_count, 0.0);
    for (const StageLap& lap : *laps) {
      trace_.add_span(frame_stages[static_cast<std::size_t>(lap.stage)].name, lap.begin, lap.end);
      allocations[static_cast<std::size_t>(lap.stage)] += static_cast<double>(lap.allocations);
    }
    trace_.add_counter("dofs", begin, {{"dofs", report.dofs}});
    trace_.add_counter("hanging nodes", begin, {{"hanging nodes", report.hanging_nodes}});
    if (heap_allocations())
      for (std::size_t k = 0; k < allocations.size(); ++k) {
        if (!stages_[k].allocations) stages_[k].allocations.emplace();
        stages_[k].allocations->push_back(allocations[k]);
      }
  }
  laps_known_ = laps_known_ && laps.has_value();
  recorder_->clear();

  const Tissue& tissue = view.tissue;
  const bool kept = scene_.dynamics->solver.method == StepMethod::kept;
  const int factorizations = tissue.solver.factorizations(), columns = tissue.solver.point_columns();
  if (sizes_) {
    const FrameTimes& times = report.times;
    StageWork assembly = assembly_work(*sizes_);
    assembly.flops *= report.newton_iterations, assembly.bytes *= report.newton_iterations;
    add_work("assemble", assembly, times.assemble_ms);
    add_work(
        "solve",
        solve_work(*sizes_, {static_cast<double>(report.solver_iterations),
                             static_cast<double>(factorizations - factorizations_), 3.0 * (columns - columns_), kept}),
        times.solve_ms);
    add_work("update", update_work(*sizes_, report.newton_iterations), times.update_ms);
  }
  factorizations_ = factorizations, columns_ = columns;
  // The next frame is solved on the mesh as it is now. That of the first frame is known only if it stayed.
  if (!sizes_ || report.refined + report.coarsened > 0) sizes_ = work_sizes(tissue.mesh.d, kept);
}

void FrameProfile::add(const StaticView& view) {
  const StaticStep& step = view.step;
  frame_ms_.push_back(step.total_ms);
  const std::int64_t begin = static_clock_;
  trace_.add_span("step " + std::to_string(step.step), begin, begin + nanoseconds(step.total_ms),
                  {{"dofs", step.dofs}, {"cells", step.cells}, {"iterations", step.iterations}, {"eta", step.eta}});
  for (const auto& [name, member] : static_stages) {
    const double ms = step.*member;
    stage(name).ms.push_back(ms);
    if (ms > 0.0) trace_.add_span(name, static_clock_, static_clock_ + nanoseconds(ms));
    static_clock_ += nanoseconds(ms);
  }
  stage("other").ms.push_back(0.0);
  trace_.add_counter("dofs", begin, {{"dofs", step.dofs}});
  trace_.add_counter("hanging nodes", begin, {{"hanging nodes", step.hanging_nodes}});

  const Discretization& d = view.discretization;
  const MeshHierarchy hierarchy = build_hierarchy(view.forest, d, support_conditions(scene_));
  const bool direct = choose_method(d, hierarchy, scene_.solver.method) == LinearMethod::direct;
  const WorkSizes sizes = work_sizes(d, direct);
  StageWork assembly = static_assembly_work(sizes);
  assembly.flops *= step.newton_iterations, assembly.bytes *= step.newton_iterations;
  add_work("assemble", assembly, step.assemble_ms + step.reduce_ms);
  StageWork solve =
      solve_work(sizes, {static_cast<double>(step.iterations), direct ? step.newton_iterations : 0.0, 0.0, direct});
  if (!direct) {
    const StageWork cycle = cycle_work(d, hierarchy);
    solve += {step.iterations * cycle.flops, step.iterations * cycle.bytes};
  }
  add_work("solve", solve, step.solve_ms);
}

Json to_json(const MachineRates& m) {
  return {{"bytes_per_second", m.bytes_per_second},
          {"flops_per_second", m.fused_flops_per_second},
          {"flops_per_second_without_fused", m.separate_flops_per_second},
          {"median_over_best", m.median_over_best},
          {"passes", m.passes}};
}

Json profile_rows(const FrameProfile& profile, const MachineRates& machine) {
  double all = 0.0;
  for (const ProfileStage& stage : profile.stages()) all += sum(stage.ms);
  Json rows = Json::array();
  for (const ProfileStage& stage : profile.stages()) {
    Json row;
    row["stage"] = stage.name;
    row["p50_ms"] = percentile(stage.ms, 50), row["p99_ms"] = percentile(stage.ms, 99);
    put(row, "share", all > 0.0, all > 0.0 ? sum(stage.ms) / all : 0.0, "the clock did not advance");
    const bool counted = stage.allocations.has_value();
    const char* why = profile.laps_known() ? "not counted for this stage, or this build's allocator cannot be counted"
                                           : "the recorded stages do not match the frame's own times";
    put(row, "allocations_p50", counted, counted ? percentile(*stage.allocations, 50) : 0.0, why);
    put(row, "allocations_max", counted, counted ? percentile(*stage.allocations, 100) : 0.0, why);
    // Rates by their medians over the frames: a frame that another process interrupted says nothing of the stage.
    StageWork mean;
    std::vector<double> flop_rates, byte_rates;
    for (std::size_t k = 0; k < stage.work.size(); ++k) {
      const StageWork& work = stage.work[k];
      const double frames = static_cast<double>(stage.work.size()), seconds = 1e-3 * std::max(stage.worked_ms[k], 1e-6);
      mean += {work.flops / frames, work.bytes / frames};
      flop_rates.push_back(work.flops / seconds), byte_rates.push_back(work.bytes / seconds);
    }
    const bool works = mean.flops > 0.0;
    const std::string reason = uncounted_work(stage.name);
    const double flops = works ? percentile(flop_rates, 50) : 0.0, bytes = works ? percentile(byte_rates, 50) : 0.0;
    put(row, "flops_per_frame", works, mean.flops, reason.c_str());
    put(row, "bytes_per_frame", works, mean.bytes, reason.c_str());
    put(row, "flops_per_second", works, flops, reason.c_str());
    put(row, "bytes_per_second", works, bytes, reason.c_str());
    put(row, "flops_of_machine", works, flops / machine.fused_flops_per_second, reason.c_str());
    put(row, "bytes_of_machine", works, bytes / machine.bytes_per_second, reason.c_str());
    if (works) row["counted"] = counted_work(stage.name);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace finegauge
