#include "benchmarks/paper/organ_cycles.hpp"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "benchmarks/paper/needle_cases.hpp"
#include "benchmarks/paper/phantom_table.hpp"
#include "benchmarks/program/allocation_counter.hpp"
#include "benchmarks/program/frame_statistics.hpp"
#include "benchmarks/program/optional_field.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/scene_reader.hpp"
#include "core/scene/start_forest.hpp"
#include "core/space/assembly.hpp"
#include "core/stopwatch.hpp"
#include "verification/support/evidence.hpp"
#include "verification/support/refinement_history.hpp"

namespace finegauge {
namespace {

constexpr double rest = 0.5;  // s; waves through the scene's organ are damped within a frame

/// Without what is free: the C library keeps some of it or gives it back as it happens to lie, megabytes from cycle to
/// cycle.
double resident_memory_mb() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
  std::ifstream statm("/proc/self/statm");
  long pages = 0, resident = 0;
  if (!(statm >> pages >> resident)) return 0.0;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// None where the C library does not tell.
std::optional<std::int64_t> heap_in_use() {
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33)
  const struct mallinfo2 heap = mallinfo2();
  return static_cast<std::int64_t>(heap.uordblks + heap.hblkhd);
#else
  return std::nullopt;
#endif
}

double largest(const Eigen::Matrix3Xd& field) { return std::sqrt(field.colwise().squaredNorm().maxCoeff()); }

/// A mesh at rest with all that follows from it.
struct RestImprint {
  TissueMesh mesh;
  BlockMatrix<double> stiffness;
};

BlockMatrix<double> stiffness_at_rest(const Discretization& d) {
  return assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
}

std::string difference(const Insertion& now, const RestImprint& then) {
  const TissueMesh& mesh = now.tissue.mesh;
  const HangingNodes &T = mesh.d.hanging, &T_then = then.mesh.d.hanging;
  if (!same_bits(mesh.d.mesh, then.mesh.d.mesh, true)) return "mesh";
  if (T.row_start != T_then.row_start || T.master != T_then.master || T.weight != T_then.weight) return "T";
  if (!same_bits(mesh.mass, then.mesh.mass)) return "mass";
  if (!same_bits(mesh.loads, then.mesh.loads)) return "loads";
  if (stiffness_at_rest(mesh.d).values != then.stiffness.values) return "stiffness";
  if (!now.tissue.release.empty()) return "loads of a change of the mesh";
  if (now.contacts.active_points() != 0 || now.contacts.tip_state() != TipState::outside) return "contacts";
  return {};
}

/// The scene's problem with as many cycles as asked for.
InsertionProblem cyclic_problem(const Scene& scene, int count) {
  InsertionProblem problem = insertion_problem(scene);
  const Stroke in = problem.drive.strokes.at(0);
  problem.drive.strokes.clear();
  for (int cycle = 0; cycle < count; ++cycle) {
    problem.drive.strokes.push_back(in);
    problem.drive.strokes.push_back({-in.displacement, in.duration});
    problem.drive.strokes.push_back({Eigen::Vector3d::Zero(), rest});
  }
  return problem;
}

/// What the frames of a cycle tell; its buffers are made once, so that measuring leaves no trace in the memory.
struct CycleFrames {
  std::vector<double> ms, new_ms, ratio, allocations;

  explicit CycleFrames(int frames) {
    for (std::vector<double>* list : {&ms, &new_ms, &ratio, &allocations})
      list->reserve(static_cast<std::size_t>(frames));
  }
  void clear() {
    for (std::vector<double>* list : {&ms, &new_ms, &ratio, &allocations}) list->clear();
  }
};

void add_report(const InsertionReport& report, OrganCycle& cycle) {
  cycle.most_dofs = std::max(cycle.most_dofs, report.frame.dofs);
  cycle.unconverged += !report.frame.converged;
  for (const ContactEvent& event : report.events) {
    cycle.punctures += event.kind == ContactEventKind::puncture;
    cycle.exits += event.kind == ContactEventKind::exit;
  }
}

/// A frame of the body that has been through many cycles, and its time.
double advance_old(const InsertionProblem& problem, Insertion& body, CycleFrames& frames, OrganCycle& cycle) {
  const std::optional<std::int64_t> before = heap_allocations();
  Stopwatch watch;
  const InsertionReport report = advance_frame(problem, body);
  const double ms = watch.lap();
  const bool quiet = report.frame.refined == 0 && report.frame.coarsened == 0 && report.events.empty();
  if (before && quiet) frames.allocations.push_back(static_cast<double>(*heap_allocations() - *before));
  add_report(report, cycle);
  return ms;
}

double advance_new(const InsertionProblem& problem, Insertion& body) {
  Stopwatch watch;
  advance_frame(problem, body);
  return watch.lap();
}

}  // namespace

OrganRun run_organ_cycles(const Scene& scene, int count, const std::function<void(double)>& progress,
                          const std::function<bool()>& interrupted) {
  const InsertionProblem problem = cyclic_problem(scene, count), single = cyclic_problem(scene, 1);
  const int frames_per_cycle = static_cast<int>(std::lround(total_duration(single.drive) / scene.dynamics->time_step));
  const RefinementForest forest = start_forest(scene);
  Insertion old = start_insertion(forest, problem);
  const RestImprint start{old.tissue.mesh, stiffness_at_rest(old.tissue.mesh.d)};
  OrganRun run{old.tissue.mesh.d.dof_count(), {}};
  run.cycles.reserve(static_cast<std::size_t>(count));
  CycleFrames frames(frames_per_cycle);
  for (int k = 0; k < count; ++k) {
    OrganCycle cycle;
    double largest_u = 0.0, largest_v = 0.0;
    {
      frames.clear();
      Insertion fresh = start_insertion(forest, single);
      for (int frame = 0; frame < frames_per_cycle; ++frame) {
        if (interrupted()) return run;
        double ms = 0.0, new_ms = 0.0;
        // In turns, so that neither always finds the caches as the other left them.
        if (frame % 2 == 0) ms = advance_old(problem, old, frames, cycle);
        new_ms = advance_new(single, fresh);
        if (frame % 2 != 0) ms = advance_old(problem, old, frames, cycle);
        frames.ms.push_back(ms);
        frames.new_ms.push_back(new_ms);
        frames.ratio.push_back(ms / new_ms);
        largest_u = std::max(largest_u, largest(old.tissue.state.u));
        largest_v = std::max(largest_v, largest(old.tissue.state.v));
      }
    }
    const Tissue& tissue = old.tissue;
    cycle.frame_ms = percentile(frames.ms, 50);
    cycle.new_ms = percentile(frames.new_ms, 50);
    cycle.ratio = percentile(frames.ratio, 50);
    if (!frames.allocations.empty()) cycle.allocations = percentile(frames.allocations, 50);
    cycle.left_u = largest(tissue.state.u) / largest_u;
    cycle.left_v = largest(tissue.state.v) / largest_v;
    cycle.dofs_at_rest = tissue.mesh.d.dof_count();
    cycle.changed = difference(old, start);
    cycle.storage_bytes = static_cast<std::int64_t>(
        tissue.forest.storage_bytes() + tissue.history.von_mises.capacity() * sizeof(double) +
        tissue.history.changed.capacity() * sizeof(int) + tissue.history.coarsened.capacity());
    cycle.resident_mb = resident_memory_mb();
    cycle.heap_bytes = heap_in_use();
    run.cycles.push_back(std::move(cycle));
    if ((k + 1) % std::max(1, count / 20) == 0) progress((k + 1.0) / count);
  }
  return run;
}

Trend trend(std::span<const double> values) {
  const double n = static_cast<double>(values.size());
  if (!(n >= 3.0))
    throw std::invalid_argument("trend: found " + std::to_string(values.size()) + " values, allowed >= 3");
  double mean = 0.0;
  for (const double value : values) mean += value / n;
  const double middle = 0.5 * (n - 1.0), spread = n * (n * n - 1.0) / 12.0;  // Σ (k - middle)²
  double slope = 0.0, residual = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k)
    slope += (static_cast<double>(k) - middle) * (values[k] - mean) / spread;
  for (std::size_t k = 0; k < values.size(); ++k)
    residual += std::pow(values[k] - mean - slope * (static_cast<double>(k) - middle), 2);
  return {slope * (n - 1.0), std::sqrt(residual / (n - 2.0) / spread) * (n - 1.0)};
}

Json checks_of_return(const std::string& name, const OrganRun& run) {
  const std::vector<OrganCycle>& cycles = run.cycles;
  const auto count = [&](const auto& is) { return static_cast<double>(std::ranges::count_if(cycles, is)); };
  const double n = static_cast<double>(cycles.size());
  double left_u = 0.0, left_v = 0.0;
  for (const OrganCycle& cycle : cycles) {
    left_u = larger(left_u, cycle.left_u);
    left_v = larger(left_v, cycle.left_v);
  }
  const std::string of = "cycles." + name + ".";
  Json checks = Json::array();
  // The cycles were cycles: one puncture, one exit, and the mesh grew.
  checks.push_back(check(of + "with_one_puncture_and_exit",
                         count([](const OrganCycle& c) { return c.punctures == 1 && c.exits == 1; }), n, n));
  checks.push_back(
      check(of + "with_refinement", count([&](const OrganCycle& c) { return c.most_dofs > run.dofs_start; }), n, n));
  checks.push_back(
      check(of + "with_unconverged_frames", count([](const OrganCycle& c) { return c.unconverged != 0; }), 0.0, 0.0));
  checks.push_back(check(of + "with_other_dofs_at_rest",
                         count([&](const OrganCycle& c) { return c.dofs_at_rest != run.dofs_start; }), 0.0, 0.0));
  checks.push_back(check(of + "not_bit_for_bit_as_at_the_start",
                         count([](const OrganCycle& c) { return !c.changed.empty(); }), 0.0, 0.0));
  // Below the solver's tolerance, 1e-9 of each step's load and 1e-8 of the contact's speed, nothing moves it further.
  checks.push_back(check(of + "displacement_left", left_u, 0.0, 1e-8));
  checks.push_back(check(of + "velocity_left", left_v, 0.0, 1e-8));
  // The first cycle makes all storage.
  checks.push_back(check(of + "storage_growth_bytes",
                         static_cast<double>(cycles.back().storage_bytes - cycles.front().storage_bytes), 0.0, 0.0));
  return checks;
}

namespace {

/// Median of a number over a tenth of the cycles, the first or the last.
double median_of_tenth(const std::vector<double>& values, bool last) {
  const std::size_t tenth = std::max<std::size_t>(1, values.size() / 10);
  const auto part = std::span(values).subspan(last ? values.size() - tenth : 0, tenth);
  return percentile(part, 50);
}

template <class Number>
std::vector<double> column(const std::vector<OrganCycle>& cycles, Number number) {
  std::vector<double> values;
  for (const OrganCycle& cycle : cycles) values.push_back(number(cycle));
  return values;
}

std::vector<double> ratios(const std::vector<OrganCycle>& cycles) {
  return column(cycles, [](const OrganCycle& c) { return c.ratio; });
}
std::vector<double> residents(const std::vector<OrganCycle>& cycles) {
  return column(cycles, [](const OrganCycle& c) { return c.resident_mb; });
}

}  // namespace

Json checks_of_growth(const std::string& name, const std::vector<OrganCycle>& cycles) {
  const std::string of = "cycles." + name + ".";
  Json checks = Json::array();
  // Two per cent over the whole run is nothing that a user could notice or a leak would stop at; three standard errors
  // are the scatter's, which has a bound of its own: a measurement that sees nothing shall not pass.
  const Trend time = trend(ratios(cycles));
  const double allowed = 0.02 + 3.0 * time.uncertainty;
  checks.push_back(check(of + "frame_time_growth", time.growth, -allowed, allowed));
  checks.push_back(check(of + "frame_time_growth_uncertainty", time.uncertainty, 0.0, 0.02));
  // Holes between blocks make it scatter by a tenth of a megabyte and may take it up a step while blocks first come in
  // all their orders; by half of the run it has settled.
  const std::vector<double> memory = residents(cycles);
  const Trend resident = trend(std::span(memory).subspan(memory.size() / 2));
  const double allowed_mb = 0.5 + 3.0 * resident.uncertainty;
  checks.push_back(check(of + "resident_growth_mb", resident.growth, -allowed_mb, allowed_mb));
  checks.push_back(check(of + "resident_growth_uncertainty_mb", resident.uncertainty, 0.0, 0.5));
  if (cycles.front().heap_bytes && cycles.back().heap_bytes) {
    // Buffers grow to the largest system that they met, which round-off may shift by a frame; a cell of the forest that
    // is lost in each cycle would be 10 kB.
    const std::size_t settled = cycles.size() / 10;
    checks.push_back(check(of + "heap_growth_kb",
                           1e-3 * static_cast<double>(*cycles.back().heap_bytes - *cycles[settled].heap_bytes), -64.0,
                           64.0));
  }
  if (cycles.front().allocations && cycles.back().allocations) {
    const auto blocks = column(cycles, [](const OrganCycle& c) { return c.allocations.value_or(0.0); });
    // Iterations on contact forces allocate too, and may differ by one here and there.
    checks.push_back(check(of + "allocations_last_tenth_over_first",
                           median_of_tenth(blocks, true) / median_of_tenth(blocks, false), 0.98, 1.02));
  }
  return checks;
}

namespace {

Json to_json(const OrganCycle& c) {
  return {{"frame_ms", c.frame_ms},
          {"new_body_frame_ms", c.new_ms},
          {"ratio", c.ratio},
          {"heap_allocations_per_quiet_frame", c.allocations ? Json(*c.allocations) : Json()},
          {"resident_mb", c.resident_mb},
          {"heap_bytes", c.heap_bytes ? Json(*c.heap_bytes) : Json()},
          {"storage_bytes", c.storage_bytes},
          {"dofs_max", c.most_dofs},
          {"dofs_at_rest", c.dofs_at_rest},
          {"displacement_left", c.left_u},
          {"velocity_left", c.left_v},
          {"punctures", c.punctures},
          {"exits", c.exits},
          {"unconverged_frames", c.unconverged},
          {"changed", c.changed}};
}

/// The medians of each tenth of the cycles.
EvidenceTable table_of_tenths(const std::string& title, const std::vector<OrganCycle>& cycles) {
  EvidenceTable table{title,
                      {"cycles", "frame p50 [ms]", "new body's", "ratio", "resident [MB]", "heap in use [kB]",
                       "blocks in a quiet frame", "most dofs", "dofs at rest"},
                      {}};
  const std::size_t n = cycles.size(), tenth = std::max<std::size_t>(1, n / 10);
  for (std::size_t first = 0; first < n; first += tenth) {
    const std::size_t last = std::min(first + tenth, n);
    const std::vector<OrganCycle> part(cycles.begin() + static_cast<std::ptrdiff_t>(first),
                                       cycles.begin() + static_cast<std::ptrdiff_t>(last));
    const auto median = [&](const auto& number) { return percentile(column(part, number), 50); };
    table.rows.push_back({std::to_string(first + 1) + "-" + std::to_string(last),
                          median([](const auto& c) { return c.frame_ms; }),
                          median([](const auto& c) { return c.new_ms; }), median([](const auto& c) { return c.ratio; }),
                          median([](const auto& c) { return c.resident_mb; }),
                          median([](const auto& c) { return 1e-3 * static_cast<double>(c.heap_bytes.value_or(0)); }),
                          median([](const auto& c) { return c.allocations.value_or(0.0); }),
                          median([](const auto& c) { return static_cast<double>(c.most_dofs); }),
                          median([](const auto& c) { return static_cast<double>(c.dofs_at_rest); })});
  }
  return table;
}

Plot cycle_plot(const std::string& file, const std::string& title, const std::string& y_label) {
  Plot plot;
  plot.file = file;
  plot.title = title;
  plot.x_label = "cycle";
  plot.y_label = y_label;
  plot.log_x = plot.log_y = false;
  return plot;
}

PlotSeries over_cycles(const std::string& label, std::vector<double> values) {
  PlotSeries series{label, {}, std::move(values)};
  for (std::size_t k = 0; k < series.y.size(); ++k) series.x.push_back(static_cast<double>(k + 1));
  return series;
}

}  // namespace

void add_organ_cycles(const StudyContext& context, double before, StudyResult& result) {
  constexpr int count = 100;
  // Steps of twice the scene's length: a tenth of a cut in each. The tolerances are those that one level of refinement
  // reaches around a needle.
  const std::vector<std::pair<std::string, std::vector<std::string>>> rules = {
      {"theta", {}}, {"tolerance", {"adapt.tolerance=0.6", "adapt.local_tolerance=0.2"}}};
  Plot times = cycle_plot("cycles_frame_time.svg", "Frame times of a hundred insertions, over those of a new body",
                          "median of the ratio");
  Plot memory = cycle_plot("cycles_memory.svg", "Resident memory after each of a hundred insertions", "resident [MB]");
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const std::string& name = rules[i].first;
    const std::vector<std::string>& overrides = rules[i].second;
    std::vector<std::string> all;
    for (const auto& [key, value] : context.overrides) all.push_back(std::string(key).append("=").append(value));
    all.emplace_back("dynamics.time_step=2e-2");
    all.insert(all.end(), overrides.begin(), overrides.end());
    const Scene scene = read_scene(scene_file("liver_phantom"), all);
    const OrganRun run = run_organ_cycles(
        scene, count,
        [&](double share) {
          const double done = (static_cast<double>(i) + share) / static_cast<double>(rules.size());
          context.progress(before + (1.0 - before) * done, "a hundred insertions, by " + name);
        },
        context.interrupted);
    const std::vector<OrganCycle>& cycles = run.cycles;
    if (static_cast<int>(cycles.size()) < count) return;
    for (const Json& made : checks_of_return(name, run)) result.checks.push_back(made);
    for (const Json& made : checks_of_growth(name, cycles)) result.checks.push_back(made);
    for (const OrganCycle& cycle : cycles) result.summary["cycles"][name].push_back(to_json(cycle));
    times.series.push_back(over_cycles(name, ratios(cycles)));
    memory.series.push_back(over_cycles(name, residents(cycles)));
    result.table.emplace_back();
    result.table.push_back(
        to_text(table_of_tenths("A hundred insertions and withdrawals, refined by " + name, cycles)));
    const Trend time = trend(ratios(cycles));
    const auto changed = std::ranges::count_if(cycles, [](const OrganCycle& c) { return !c.changed.empty(); });
    result.table.push_back(
        "frame time over a new body's, growth from the first cycle to the last: " + short_number(100.0 * time.growth) +
        " % ± " + short_number(100.0 * time.uncertainty) +
        " %; cycles after which something is not bit for bit as at the start: " + std::to_string(changed));
  }
  result.plots.push_back(std::move(times));
  result.plots.push_back(std::move(memory));
}

}  // namespace finegauge
