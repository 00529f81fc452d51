#include "benchmarks/profile/tjunction_overhead.hpp"

#include <algorithm>

#include "benchmarks/program/frame_statistics.hpp"
#include "benchmarks/program/optional_field.hpp"

namespace finegauge {
namespace {

// How often a frame crosses between all nodes and those that do not hang (core/tissue_step.cpp,
// core/tissue_energy.cpp): for each linearization u and v to all nodes, and internal forces of the assembly and of the
// equilibrium error, with their damping, to the masters; for each frame the two vectors of forces that the energy
// ledger asks for.
constexpr int expansions_per_linearization = 2, gathers_per_linearization = 3, gathers_per_frame = 2;

struct Sums {
  double frame = 0.0, build = 0.0, reduce = 0.0, expand = 0.0;
  void add(const TjunctionFrame& f) {
    frame += f.frame_ms, build += f.build_ms, reduce += f.reduce_ms, expand += f.expand_ms;
  }
};

Json shares(const Sums& sums) {
  Json json;
  const bool known = sums.frame > 0.0;
  const double scale = known ? 1.0 / sums.frame : 0.0;
  put(json, "build", known, scale * sums.build, "no such frames");
  put(json, "reduce", known, scale * sums.reduce, "no such frames");
  put(json, "expand", known, scale * sums.expand, "no such frames");
  put(json, "all", known, scale * (sums.build + sums.reduce + sums.expand), "no such frames");
  return json;
}

}  // namespace

void TjunctionOverhead::observe(const MotionView& view) {
  const FrameReport& report = view.frame.report.frame;
  const Discretization& d = view.tissue.mesh.d;
  const bool changed = report.refined + report.coarsened > 0;
  // The mesh of the first frame is no longer there when it was changed; it has no hanging nodes, or what it has is
  // charged to the frames that follow.
  const TjunctionTimes solved_on = times_;
  if (changed || frames_.empty()) {
    times_ = time_tjunctions(view.tissue.forest, d, view.tissue.state.u, repetitions_);
    ++meshes_;
  }
  const TjunctionTimes& times = frames_.empty() && !changed ? times_ : solved_on;
  TjunctionFrame frame;
  frame.frame_ms = report.times.total();
  frame.hanging_nodes = report.hanging_nodes;
  if (changed) frame.build_ms = times_.build_ms;
  frame.reduce_ms = report.newton_iterations * times.reduce_ms;
  frame.expand_ms = report.newton_iterations *
                        (expansions_per_linearization * times.expand_ms + gathers_per_linearization * times.gather_ms) +
                    gathers_per_frame * times.gather_ms;
  frames_.push_back(frame);
}

double overhead_share(const TjunctionOverhead& overhead) {
  Sums sums;
  for (const TjunctionFrame& frame : overhead.frames()) sums.add(frame);
  return (sums.build + sums.reduce + sums.expand) / sums.frame;
}

Json overhead_summary(const TjunctionOverhead& overhead) {
  Sums all, hanging, changed;
  std::vector<double> share_of_frame;
  int largest = 0;
  for (const TjunctionFrame& frame : overhead.frames()) {
    all.add(frame);
    largest = std::max(largest, frame.hanging_nodes);
    if (frame.build_ms > 0.0) changed.add(frame);
    if (frame.hanging_nodes == 0) continue;
    hanging.add(frame);
    if (frame.frame_ms > 0.0) share_of_frame.push_back(std::max(0.0, frame.overhead_ms() / frame.frame_ms));
  }
  Json json;
  json["frames"] = overhead.frames().size();
  json["frames_with_hanging_nodes"] = share_of_frame.size();
  json["meshes"] = overhead.meshes();
  json["hanging_nodes_max"] = largest;
  json["share"] = shares(all);
  json["share_of_frames_with_hanging_nodes"] = shares(hanging);
  json["share_of_frames_that_change_the_mesh"] = shares(changed);
  const bool known = !share_of_frame.empty();
  put(json, "p50", known, known ? percentile(share_of_frame, 50) : 0.0, "no node ever hung");
  put(json, "p99", known, known ? percentile(share_of_frame, 99) : 0.0, "no node ever hung");
  return json;
}

}  // namespace finegauge
