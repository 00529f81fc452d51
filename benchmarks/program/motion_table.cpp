#include <algorithm>
#include <cmath>
#include <cstdio>

#include "benchmarks/program/frame_rows.hpp"
#include "benchmarks/program/motion_output.hpp"

namespace finegauge {
namespace {

constexpr std::size_t table_lines = 20;

void print_header(const Scene& scene) {
  const bool plain = scene.dimensionless;
  std::printf("%7s %11s", "frame", plain ? "time" : "time [s]");
  if (scene.needle)
    std::printf(" %12s %11s %8s", plain ? "tip" : "tip [m]", plain ? "force" : "force [N]", "tip is");
  else
    std::printf(" %12s %11s", plain ? "kinetic" : "kinetic [J]", plain ? "elastic" : "elastic [J]");
  std::printf(" %8s %8s %8s %6s %6s %9s\n", "dofs", "cells", "eta [%]", "iter", "Uzawa", "[ms]");
}

void print_frame(const Scene& scene, const MotionFrame& frame) {
  const InsertionReport& r = frame.report;
  const FrameReport& f = r.frame;
  std::printf("%7d %11.5g", f.frame, f.time);
  if (scene.needle)
    std::printf(" %12.5g %11.5g %8s", r.tip_displacement, r.force, std::string(to_string(r.tip_state)).c_str());
  else
    std::printf(" %12.5g %11.5g", f.energy.kinetic, f.energy.elastic);
  char eta[24] = "-";
  if (f.eta) std::snprintf(eta, sizeof eta, "%.3f", 100.0 * *f.eta);
  std::printf(" %8d %8d %8s %6d %6d %9.2f%s\n", f.dofs, f.cells, eta, f.solver_iterations, f.uzawa_iterations,
              frame.frame_ms, f.converged ? "" : "  NOT CONVERGED");
}

/// Stick and slip come often and are only counted, in the summary.
void print_event(const ContactEvent& event, bool dimensionless) {
  if (event.kind == ContactEventKind::stick || event.kind == ContactEventKind::slip) return;
  std::printf("        %11.5g  %s at depth %.5g%s, force %.5g%s\n", event.time,
              std::string(to_string(event.kind)).c_str(), event.depth, dimensionless ? "" : " m", event.force,
              dimensionless ? "" : " N");
}

/// Where both tolerances are asked for: ", of the whole body on 793, of the worst cell on 791".
std::string both_tolerances(const Json& t) {
  if (!t.at("global_met_frames").is_number() || !t.at("local_met_frames").is_number()) return {};
  return ", of the whole body on " + t.at("global_met_frames").dump() + ", of the worst cell on " +
         t.at("local_met_frames").dump();
}

/// "0.123" of a number, "none" of null.
std::string digits(const Json& value, const char* format = "%.4g") {
  if (!value.is_number() || !std::isfinite(value.get<double>())) return "none";
  char text[48];
  std::snprintf(text, sizeof text, format, value.get<double>());
  return text;
}

void print_summary(const Json& s) {
  const Json &ms = s.at("frame_ms"), &dofs = s.at("dofs"), &eta = s.at("eta"), &energy = s.at("energy");
  std::printf("%d frames, %s frames/s; frame p50 %s, p95 %s, p99 %s, max %s ms\n", s.at("frames").get<int>(),
              digits(s.at("frames_per_second")).c_str(), digits(ms.at("p50")).c_str(), digits(ms.at("p95")).c_str(),
              digits(ms.at("p99")).c_str(), digits(ms.at("max")).c_str());
  if (s.at("deadline_ms").is_number())
    std::printf("deadline %s ms: %d frames missed, at most %d in a row\n", digits(s.at("deadline_ms")).c_str(),
                s.at("missed_frames").get<int>(), s.at("longest_miss_streak").get<int>());
  std::printf("dofs: start %d, max %d, end %d; refined %d, coarsened %d\n", dofs.at("start").get<int>(),
              dofs.at("max").get<int>(), dofs.at("end").get<int>(), s.at("refined").get<int>(),
              s.at("coarsened").get<int>());
  std::printf("eta: start %s, max %s, end %s\n", digits(eta.at("start")).c_str(), digits(eta.at("max")).c_str(),
              digits(eta.at("end")).c_str());
  if (const Json& t = s.at("tolerance"); t.at("share").is_number())
    std::printf(
        "tolerance: met on %d of %d frames (%.1f %%)%s, at worst %s times it; %d frames limited by depth, %d by "
        "dofs\n",
        t.at("met_frames").get<int>(), t.at("asked_frames").get<int>(), 100.0 * t.at("share").get<double>(),
        both_tolerances(t).c_str(), digits(t.at("worst"), "%.3g").c_str(), t.at("frames_limited_by_depth").get<int>(),
        t.at("frames_limited_by_dofs").get<int>());
  if (const Json& p = s.at("popping"); p.at("mesh_changes").is_number())
    std::printf(
        "mesh changes: %d, each over %d frames; toggles per cell and second %s%s\n", p.at("mesh_changes").get<int>(),
        std::max(1, p.at("release_frames").get<int>()), digits(p.at("toggles_per_cell_and_second"), "%.3g").c_str(),
        p.at("largest_excess").is_number()
            ? ("; of the largest force, asked for at most " + digits(p.at("largest_asked"), "%.3g") + ", excess " +
               digits(p.at("largest_excess"), "%.3g") + ", in one frame " + digits(p.at("largest_step"), "%.3g"))
                  .c_str()
            : "");
  std::printf("energy: kinetic %s, elastic %s, work %s, dissipated %s, closure %s of the largest\n",
              digits(energy.at("kinetic")).c_str(), digits(energy.at("elastic")).c_str(),
              digits(energy.at("work")).c_str(), digits(energy.at("dissipated")).c_str(),
              digits(energy.at("relative_closure")).c_str());
  if (!s.contains("events")) return;
  std::string counts;
  for (const auto& [kind, count] : s.at("events").items())
    if (count.get<int>() > 0) counts += (counts.empty() ? "" : ", ") + std::to_string(count.get<int>()) + " " + kind;
  std::printf("largest force %s; events: %s\n", digits(s.at("largest_force"), "%.5g").c_str(),
              counts.empty() ? "none" : counts.c_str());
}

}  // namespace

void print_motion(const Scene& scene, const MotionRun& run, const Json& summary,
                  const std::vector<std::string>& notes) {
  print_header(scene);
  const std::size_t count = run.frames.size();
  int failures_left = 5;  // shown beside the table's own lines
  for (std::size_t i = 0; i < count; ++i) {
    // The last frame of each twentieth, and so the last of all.
    const bool shown = count <= table_lines || (i + 1) * table_lines / count > i * table_lines / count;
    const bool failed = !run.frames[i].report.frame.converged && failures_left-- > 0;
    if (shown || failed) print_frame(scene, run.frames[i]);
    for (const ContactEvent& event : run.frames[i].report.events) print_event(event, scene.dimensionless);
  }
  print_summary(summary);
  if (summary.contains("quantities"))
    for (const auto& [name, value] : summary.at("quantities").items())
      std::printf("%s = %s\n", name.c_str(), value.dump().c_str());
  std::printf("stopped: %s\n", run.stopped_because.c_str());
  for (const std::string& note : notes) std::printf("note: %s\n", note.c_str());
  std::fflush(stdout);
}

}  // namespace finegauge
