#include "benchmarks/program/frame_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "benchmarks/program/adaptivity_summary.hpp"
#include "benchmarks/program/certificate.hpp"
#include "benchmarks/program/frame_statistics.hpp"
#include "benchmarks/program/optional_field.hpp"
#include "benchmarks/program/sha256.hpp"

namespace finegauge {
namespace {

constexpr const char* no_needle = "the scene has no needle";
constexpr const char* no_estimate = "estimate_error = false";

Json to_json(const EnergyLedger& energy) {
  return {{"kinetic", energy.kinetic}, {"elastic", energy.elastic},       {"work", energy.work},
          {"release", energy.release}, {"dissipated", energy.dissipated}, {"closure", energy.closure}};
}

Json to_json(const std::vector<ContactEvent>& events) {
  Json list = Json::array();
  for (const ContactEvent& event : events)
    list.push_back({{"kind", std::string(to_string(event.kind))},
                    {"time", event.time},
                    {"depth", event.depth},
                    {"force", event.force}});
  return list;
}

std::vector<double> collect(const MotionRun& run, auto value_of) {
  std::vector<double> values;
  values.reserve(run.frames.size());
  for (const MotionFrame& frame : run.frames) values.push_back(value_of(frame));
  return values;
}

Json start_max_end(const MotionRun& run, int FrameReport::*member) {
  int largest = 0;
  for (const MotionFrame& frame : run.frames) largest = std::max(largest, frame.report.frame.*member);
  return {{"start", run.frames.front().report.frame.*member},
          {"max", largest},
          {"end", run.frames.back().report.frame.*member}};
}

Json mean_max(const MotionRun& run, int FrameReport::*member) {
  double sum = 0.0;
  int largest = 0;
  for (const MotionFrame& frame : run.frames) {
    sum += frame.report.frame.*member;
    largest = std::max(largest, frame.report.frame.*member);
  }
  return {{"mean", sum / static_cast<double>(run.frames.size())}, {"max", largest}};
}

Json stage_statistics(const MotionRun& run) {
  constexpr std::pair<const char*, double FrameTimes::*> stages[] = {
      {"assemble", &FrameTimes::assemble_ms}, {"needle", &FrameTimes::needle_ms},
      {"contact", &FrameTimes::contact_ms},   {"solve", &FrameTimes::solve_ms},
      {"update", &FrameTimes::update_ms},     {"estimate", &FrameTimes::estimate_ms},
      {"mark", &FrameTimes::mark_ms},         {"topology", &FrameTimes::topology_ms},
      {"transfer", &FrameTimes::transfer_ms}};
  Json statistics = Json::object();
  for (const auto& [name, member] : stages) {
    const FrameStatistics p =
        frame_times(collect(run, [m = member](const MotionFrame& f) { return f.report.frame.times.*m; }));
    statistics[name] = {{"p50", p.p50}, {"p99", p.p99}};
  }
  return statistics;
}

Json eta_summary(const Scene& scene, const MotionRun& run) {
  Json eta = Json::object();
  const bool known = scene.dynamics->estimate_error;
  double largest = 0.0;
  for (const MotionFrame& frame : run.frames) largest = std::max(largest, frame.report.frame.eta.value_or(0.0));
  put(eta, "start", known ? run.frames.front().report.frame.eta : std::nullopt, no_estimate);
  put(eta, "max", known, largest, no_estimate);
  put(eta, "end", known ? run.frames.back().report.frame.eta : std::nullopt, no_estimate);
  return eta;
}

void put_allocations(const MotionRun& run, Json& summary) {
  std::vector<double> quiet;
  bool counted = true;
  for (const MotionFrame& frame : run.frames) {
    counted = counted && frame.heap_allocations.has_value();
    if (counted && frame.quiet()) quiet.push_back(static_cast<double>(*frame.heap_allocations));
  }
  put(summary, "heap_allocations_per_quiet_frame", counted && !quiet.empty(),
      quiet.empty() ? 0.0 : percentile(quiet, 50),
      counted ? "every frame changed the mesh or the contact" : "this build's allocator cannot be counted");
}

void put_deadline(const Scene& scene, const std::vector<double>& frame_ms, Json& summary) {
  const std::optional<double>& deadline = scene.dynamics->deadline_ms;
  put(summary, "deadline_ms", deadline, "the scene has no deadline");
  summary["missed_frames"] = nullptr, summary["longest_miss_streak"] = nullptr;
  if (!deadline) {
    summary["missed_frames_reason"] = summary["longest_miss_streak_reason"] = summary["deadline_ms_reason"];
    return;
  }
  const DeadlineMisses misses = deadline_misses(frame_ms, *deadline);
  summary["missed_frames"] = misses.missed;
  summary["longest_miss_streak"] = misses.longest_streak;
}

Json event_counts(const MotionRun& run) {
  Json counts = Json::object();
  for (const auto kind :
       {ContactEventKind::touch, ContactEventKind::release, ContactEventKind::puncture, ContactEventKind::cut,
        ContactEventKind::stick, ContactEventKind::slip, ContactEventKind::retract, ContactEventKind::exit}) {
    int count = 0;
    for (const MotionFrame& frame : run.frames)
      count += static_cast<int>(std::ranges::count(frame.report.events, kind, &ContactEvent::kind));
    counts[std::string(to_string(kind))] = count;
  }
  return counts;
}

Json largest_and_final(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = larger(largest, value);
  return {{"largest", largest}, {"final", values.back()}};
}

/// Beyond what equilibrium asks for, a change of the mesh may add this share of the largest force.
constexpr double allowed_excess = 0.02;

Json quantity_summary(const Scene& scene, const MotionRun& run) {
  Json summary = Json::object();
  for (const QuantityOfInterest& quantity : scene.quantities) {
    const std::string& name = quantity.name;
    switch (quantity.kind) {
      case QuantityKind::energy:
        summary[name] =
            largest_and_final(collect(run, [&](const MotionFrame& f) { return f.quantities.at(name).get<double>(); }));
        break;
      case QuantityKind::displacement: {
        const std::vector<double> lengths = collect(run, [&](const MotionFrame& f) {
          const Json& u = f.quantities.at(name);
          return std::hypot(u[0].get<double>(), u[1].get<double>(), u[2].get<double>());
        });
        const auto largest = std::ranges::max_element(lengths) - lengths.begin();
        summary[name] = {{"largest", run.frames[static_cast<std::size_t>(largest)].quantities.at(name)},
                         {"final", run.frames.back().quantities.at(name)}};
        break;
      }
      case QuantityKind::tip_force:
        summary[name] = largest_and_final(collect(run, [](const MotionFrame& f) { return f.report.tip_force; }));
        break;
      case QuantityKind::force_curve:
        summary[name] = {{"file", scene.name + ".csv"}, {"x", "tip_displacement"}, {"y", "force"}};
        break;
    }
  }
  return summary;
}

}  // namespace

Json to_json(const MotionFrame& frame, const Scene& scene) {
  const InsertionReport& r = frame.report;
  const FrameReport& f = r.frame;
  const bool needle = scene.needle.has_value();
  Json row;
  row["frame"] = f.frame, row["time"] = f.time;
  put(row, "tip_displacement", needle, r.tip_displacement, no_needle);
  put(row, "force", needle, r.force, no_needle);
  put(row, "tip_force", needle, r.tip_force, no_needle);
  put(row, "shaft_force", needle, r.shaft_force, no_needle);
  put(row, "across_force", needle, r.across_force, no_needle);
  put(row, "base_force", needle, r.base_force, no_needle);
  row["dofs"] = f.dofs, row["cells"] = f.cells, row["hanging_nodes"] = f.hanging_nodes;
  put(row, "eta", f.eta, no_estimate);
  put(row, "eta_local_max", f.eta_local_max, no_estimate);
  const std::optional<CertifiedRange> certified =
      f.eta ? certified_range(scene, *f.eta, f.converged) : std::optional<CertifiedRange>();
  const std::string uncertified = f.eta ? why_uncertified(scene, *f.eta, f.converged) : no_estimate;
  put(row, "error_low", certified.has_value(), certified ? certified->low : 0.0, uncertified.c_str());
  put(row, "error_high", certified.has_value(), certified ? certified->high : 0.0, uncertified.c_str());
  row["equilibrium_error"] = f.equilibrium_error;
  row["tolerance_met"] = f.tolerance_met;
  put_tolerance(scene, f, row);
  row["converged"] = f.converged;
  row["residual"] = f.residual, row["violation"] = f.violation;
  row["solver_iterations"] = f.solver_iterations, row["uzawa_iterations"] = f.uzawa_iterations;
  row["newton_iterations"] = f.newton_iterations;
  row["refined"] = f.refined, row["coarsened"] = f.coarsened;
  row["toggles"] = f.toggles, row["releasing"] = f.releasing;
  row["energy"] = to_json(f.energy);
  if (needle) {
    row["insertion_depth"] = r.insertion_depth;
    row["tip_state"] = std::string(to_string(r.tip_state));
    row["contact_points"] = r.contact_points;
  }
  if (!frame.quantities.empty()) row["quantities"] = frame.quantities;
  row["frame_ms"] = frame.frame_ms, row["processor_ms"] = frame.processor_ms;
  row["events"] = to_json(r.events);
  return row;
}

Json summarize(const Scene& scene, const MotionRun& run) {
  const std::vector<double> frame_ms = collect(run, [](const MotionFrame& f) { return f.frame_ms; });
  double total_ms = 0.0;
  for (const double ms : frame_ms) total_ms += ms;
  const FrameStatistics p = frame_times(frame_ms);
  int refined = 0, coarsened = 0, unconverged = 0;
  double violation = 0.0;
  for (const MotionFrame& frame : run.frames) {
    const FrameReport& f = frame.report.frame;
    refined += f.refined, coarsened += f.coarsened, unconverged += !f.converged;
    violation = larger(violation, f.violation);
  }

  Json summary;
  summary["frames"] = run.frames.size();
  summary["simulated_seconds"] = run.frames.back().report.frame.time;
  put(summary, "frames_per_second", total_ms > 0.0, 1e3 * static_cast<double>(run.frames.size()) / total_ms,
      "the clock did not advance");
  summary["frame_ms"] = {{"p50", p.p50}, {"p95", p.p95}, {"p99", p.p99}, {"max", p.max}};
  put_deadline(scene, frame_ms, summary);
  summary["stages_ms"] = stage_statistics(run);
  summary["dofs"] = start_max_end(run, &FrameReport::dofs);
  summary["cells"] = start_max_end(run, &FrameReport::cells);
  summary["hanging_nodes"] = {{"max", start_max_end(run, &FrameReport::hanging_nodes)["max"]}};
  summary["eta"] = eta_summary(scene, run);
  summary["tolerance"] = tolerance_summary(scene, run);
  summary["refined"] = refined, summary["coarsened"] = coarsened;
  summary["popping"] = popping_summary(scene, run);
  summary["solver_iterations"] = mean_max(run, &FrameReport::solver_iterations);
  summary["uzawa_iterations"] = mean_max(run, &FrameReport::uzawa_iterations);
  summary["constraint_violation_max"] = violation;
  summary["unconverged_frames"] = unconverged;
  if (const std::string failure = convergence_failure(run); !failure.empty()) summary["first_unconverged"] = failure;
  put_allocations(run, summary);
  summary["energy"] = to_json(run.frames.back().report.frame.energy);
  summary["energy"]["relative_closure"] = relative_closure(run);
  if (scene.needle) {
    summary["largest_force"] =
        largest_and_final(collect(run, [](const MotionFrame& f) { return f.report.force; }))["largest"];
    summary["buckling_load"] = run.buckling_load;
    summary["events"] = event_counts(run);
  }
  if (!scene.quantities.empty()) summary["quantities"] = quantity_summary(scene, run);
  summary["stopped_because"] = run.stopped_because;
  summary["peak_memory_mb"] = peak_memory_mb();
  summary["state_sha256"] = sha256(std::as_bytes(std::span(run.final_state)));
  return summary;
}

Json motion_checks(const MotionRun& run, bool ended_by_user) {
  Json checks = Json::array();
  const auto unconverged =
      std::ranges::count_if(run.frames, [](const MotionFrame& f) { return !f.report.frame.converged; });
  checks.push_back(check("unconverged_frames", static_cast<double>(unconverged), 0.0, 0.0));
  if (!ended_by_user)
    checks.push_back(check("frames", static_cast<double>(run.frames.size()), run.planned_frames, run.planned_frames));
  double largest_force = 0.0;
  for (const MotionFrame& frame : run.frames) largest_force = std::max(largest_force, std::abs(frame.report.force));
  if (run.mesh_changes.empty()) return checks;
  if (const PoppingSummary popping = summarize(run.mesh_changes); popping.judged > 0 && largest_force > 0.0)
    checks.push_back(check("popping_excess", popping.largest_excess / largest_force, 0.0, allowed_excess));
  return checks;
}

std::string convergence_failure(const MotionRun& run) {
  const auto failed = [](const MotionFrame& f) { return !f.report.frame.converged; };
  const auto first = std::ranges::find_if(run.frames, failed);
  if (first == run.frames.end()) return {};
  const FrameReport& f = first->report.frame;
  char text[256];
  std::snprintf(text, sizeof text,
                "%d of %zu frames did not converge, the first is frame %d (t = %.6g): residual %.3g, violation %.3g, "
                "%d iterations of the solver, %d of Uzawa",
                static_cast<int>(std::ranges::count_if(run.frames, failed)), run.frames.size(), f.frame, f.time,
                f.residual, f.violation, f.solver_iterations, f.uzawa_iterations);
  return text;
}

double relative_closure(const MotionRun& run) {
  double largest = 0.0;
  for (const MotionFrame& frame : run.frames) {
    const EnergyLedger& e = frame.report.frame.energy;
    largest = std::max({largest, std::abs(e.kinetic) + std::abs(e.elastic) + std::abs(e.dissipated), std::abs(e.work)});
  }
  return largest > 0.0 ? run.frames.back().report.frame.energy.closure / largest : 0.0;
}

namespace {

/// The ledger of a run that followed its motion closes to a percent or so; one that does not has forces and energies of
/// its own.
std::optional<std::string> note_on_closure(const Scene& scene, const MotionRun& run) {
  constexpr double noted = 0.05;
  const double closure = relative_closure(run);
  if (std::abs(closure) <= noted) return {};
  const FrameReport* worst = &run.frames.front().report.frame;
  for (const MotionFrame& frame : run.frames)
    if (!frame.report.frame.at_rest && frame.report.frame.equilibrium_error > worst->equilibrium_error)
      worst = &frame.report.frame;
  char text[400];
  std::snprintf(text, sizeof text,
                "energy: %.2g %% of the largest is unaccounted for, so forces are not to be trusted: the steps do not "
                "follow the motion (equilibrium_error up to %.2g, at t = %.4g)%s",
                100.0 * std::abs(closure), worst->equilibrium_error, worst->time,
                scene.needle ? "; a needle that presses soft tissue in deeper than a cell is long folds the cells: "
                               "a lower puncture_strength or a larger coupling_radius; or a shorter time_step"
                             : "; shorten time_step");
  return text;
}

/// Why the iteration on contact forces may end at its limit: core/needle/interaction.hpp.
std::optional<std::string> note_on_contact(const Scene& scene, const MotionRun& run) {
  if (!scene.needle) return {};
  const auto at_the_limit = [&](const MotionFrame& frame) {
    const FrameReport& f = frame.report.frame;
    return !f.converged && f.uzawa_iterations >= scene.needle->interaction.iterations;
  };
  const auto count = std::ranges::count_if(run.frames, at_the_limit);
  if (count == 0) return {};
  return "contact forces did not settle within contact.iterations in " + std::to_string(count) +
         " frames: points of the path that are closer than half a cell feel almost the same tissue; a larger "
         "cut_advance, smaller cells or more iterations";
}

}  // namespace

std::vector<std::string> run_notes(const Scene& scene, const MotionRun& run) {
  std::vector<std::string> notes = run.notes;
  if (auto note = note_on_contact(scene, run)) notes.push_back(std::move(*note));
  if (auto note = note_on_closure(scene, run)) notes.push_back(std::move(*note));
  if (!scene.needle || scene.needle->drive.guided) return notes;
  double largest = 0.0;
  for (const MotionFrame& frame : run.frames) largest = std::max(largest, frame.report.force);
  if (largest > run.buckling_load) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "the largest force, %.4g, is above the needle's buckling load, %.4g (fixed at its base, free at its "
                  "tip), and nothing guides it",
                  largest, run.buckling_load);
    notes.emplace_back(text);
  }
  return notes;
}

}  // namespace finegauge
