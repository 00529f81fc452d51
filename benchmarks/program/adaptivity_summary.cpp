#include "benchmarks/program/adaptivity_summary.hpp"

#include <algorithm>
#include <cmath>

#include "benchmarks/program/optional_field.hpp"

namespace finegauge {
namespace {

constexpr const char* no_tolerance = "the scene asks for no tolerance";
constexpr const char* no_adapt = "the scene's mesh does not adapt";
constexpr const char* no_energy = "an error without energy";
constexpr const char* not_of_body = "the scene asks for no tolerance of the whole body's error";
constexpr const char* not_of_cells = "the scene asks for no tolerance of the worst cell's error";

bool asks_for_tolerance(const Scene& scene) {
  return scene.dynamics->adapt && asks_for_tolerance(*scene.dynamics->adapt);
}

}  // namespace

void put_tolerance(const Scene& scene, const FrameReport& frame, Json& row) {
  const bool asked = asks_for_tolerance(scene);
  put(row, "tolerance_ratio", asked && std::isfinite(frame.tolerance_ratio), frame.tolerance_ratio,
      asked ? no_energy : no_tolerance);
  row["at_rest"] = frame.at_rest;
  row["limit"] = frame.limit == AdaptLimit::depth ? "depth" : frame.limit == AdaptLimit::dofs ? "dofs" : "none";
}

Json tolerance_summary(const Scene& scene, const MotionRun& run) {
  Json tolerance = Json::object();
  int asked = 0, met = 0, by_depth = 0, by_dofs = 0, global_met = 0, local_met = 0;
  double worst = 0.0;
  const FrameAdaptRules rules = scene.dynamics->adapt.value_or(FrameAdaptRules{});
  for (const MotionFrame& frame : run.frames) {
    const FrameReport& f = frame.report.frame;
    if (f.at_rest) continue;
    ++asked;
    met += f.tolerance_met;
    by_depth += !f.tolerance_met && f.limit == AdaptLimit::depth;
    by_dofs += !f.tolerance_met && f.limit == AdaptLimit::dofs;
    worst = larger(worst, f.tolerance_ratio);
    global_met += f.eta && *f.eta <= rules.tolerance;
    local_met += f.eta_local_max && *f.eta_local_max <= rules.local_tolerance;
  }
  const bool known = asks_for_tolerance(scene);
  const char* why_not = known ? "the body was at rest in all frames" : no_tolerance;
  put(tolerance, "asked_frames", known, asked, why_not);
  put(tolerance, "met_frames", known, met, why_not);
  put(tolerance, "global_met_frames", known && rules.tolerance > 0.0, global_met, known ? not_of_body : why_not);
  put(tolerance, "local_met_frames", known && rules.local_tolerance > 0.0, local_met, known ? not_of_cells : why_not);
  put(tolerance, "share", known && asked > 0, asked > 0 ? static_cast<double>(met) / asked : 0.0, why_not);
  put(tolerance, "worst", known && asked > 0 && std::isfinite(worst), worst, known && asked > 0 ? no_energy : why_not);
  put(tolerance, "frames_limited_by_depth", known, by_depth, why_not);
  put(tolerance, "frames_limited_by_dofs", known, by_dofs, why_not);
  return tolerance;
}

Json popping_summary(const Scene& scene, const MotionRun& run) {
  Json popping = Json::object();
  const bool adapts = scene.dynamics->adapt.has_value();
  int changes = 0, toggles = 0;
  double cell_seconds = 0.0, largest_force = 0.0;
  for (const MotionFrame& frame : run.frames) {
    const FrameReport& f = frame.report.frame;
    changes += f.refined > 0 || f.coarsened > 0;
    toggles += f.toggles;
    cell_seconds += f.cells * scene.dynamics->time_step;
    largest_force = std::max(largest_force, std::abs(frame.report.force));
  }
  put(popping, "release_frames", adapts, adapts ? scene.dynamics->adapt->release : 0, no_adapt);
  put(popping, "mesh_changes", adapts, changes, no_adapt);
  put(popping, "toggles", adapts, toggles, no_adapt);
  put(popping, "toggles_per_cell_and_second", adapts && cell_seconds > 0.0,
      cell_seconds > 0.0 ? toggles / cell_seconds : 0.0, adapts ? "no time has passed" : no_adapt);
  if (!scene.dynamics->check_popping) {
    for (const char* key : {"judged_changes", "largest_excess", "largest_step", "largest_asked"})
      put(popping, key, false, 0.0, "check_popping = false");
    return popping;
  }
  const bool pressed = largest_force > 0.0;
  const PoppingSummary summary = summarize(run.mesh_changes);
  const double unit = pressed ? 1.0 / largest_force : 0.0;
  popping["judged_changes"] = summary.judged;
  put(popping, "largest_excess", pressed, unit * summary.largest_excess, "there was no force");
  put(popping, "largest_step", pressed, unit * summary.largest_step, "there was no force");
  put(popping, "largest_asked", pressed, unit * summary.largest_asked, "there was no force");
  return popping;
}

}  // namespace finegauge
