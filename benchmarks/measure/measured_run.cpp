#include "benchmarks/measure/measured_run.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <numeric>
#include <utility>

#include "benchmarks/program/moving_simulation.hpp"
#include "benchmarks/program/processor_time.hpp"
#include "benchmarks/program/static_run.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/scene_error.hpp"

namespace finegauge {
namespace {

/// What a run passes by at the instants: where in time, and what is done there.
struct InstantVisitor {
  std::vector<double> times;  ///< ascending
  std::function<void(std::size_t instant, const RefinementForest&, const Mesh&, const Eigen::Matrix3Xd& u)> visit;
};

void add_needle(const MotionFrame& frame, RunCurves& curves) {
  curves.travel.push_back(frame.report.tip_displacement);
  curves.force.push_back(frame.report.force);
  curves.tip_force.push_back(frame.report.tip_force);
}

void add_frame(const MotionFrame& frame, bool needle, MeasuredRun& run) {
  const FrameReport& report = frame.report.frame;
  run.curves.add(report.time, frame.quantities);
  if (needle) add_needle(frame, run.curves);
  if (run.frames++ == 0) run.dofs_start = report.dofs;
  run.dofs_end = report.dofs;
  run.dofs_max = std::max(run.dofs_max, report.dofs);
  run.dofs_mean += report.dofs;
  run.unconverged += !report.converged;
  run.refined += report.refined;
  run.coarsened += report.coarsened;
  const int iterations = report.solver_iterations + report.uzawa_iterations;
  run.iterations += iterations;
  run.work += static_cast<double>(report.dofs) * (1.0 + iterations);
  if (report.eta) run.eta_max = std::max(run.eta_max.value_or(0.0), *report.eta);
}

/// One pass from rest; the first one leaves what it found in `run`. False when stopped.
bool pass_moving(const Scene& scene, bool first, const InstantVisitor& instants,
                 const std::function<bool(double)>& go_on, MeasuredRun& run) {
  MovingSimulation simulation(scene);
  std::vector<double>& times = run.frame_ms.emplace_back();
  const double half_step = 0.5 * scene.dynamics->time_step;
  std::size_t next = 0;
  for (int i = 0; i < simulation.planned_frames(); ++i) {
    const MotionFrame frame = simulation.advance();
    times.push_back(frame.processor_ms);
    if (first) {
      add_frame(frame, simulation.insertion() != nullptr, run);
      const double time = frame.report.frame.time;
      const bool last = i + 1 == simulation.planned_frames();
      for (; next < instants.times.size() && (last || instants.times[next] < time + half_step); ++next)
        instants.visit(next, simulation.tissue().forest, simulation.tissue().mesh.d.mesh, simulation.tissue().state.u);
    }
    if (!go_on((i + 1.0) / simulation.planned_frames())) return false;
  }
  return true;
}

/// The same of a static scene, whose one frame is its adaptive loop.
bool pass_static(const Scene& scene, bool first, const InstantVisitor& instants,
                 const std::function<bool(double)>& go_on, MeasuredRun& run) {
  bool stopped = false;
  double elsewhere = 0.0;  // processor time of what is no part of the loop
  const double start = processor_ms();
  const StaticRun made = run_static(scene, [&](const StaticView& view) {
    const double before = processor_ms();
    if (first && view.last)
      for (std::size_t i = 0; i < instants.times.size(); ++i)
        instants.visit(i, view.forest, view.discretization.mesh, view.u);
    const double planned = scene.adapt ? scene.adapt->steps + 1.0 : 1.0;
    stopped = !go_on(view.last ? 1.0 : (view.step.step + 1.0) / planned) && !view.last;
    elsewhere += processor_ms() - before;
    return !stopped;
  });
  run.frame_ms.push_back({processor_ms() - start - elsewhere});
  if (!first) return !stopped;
  const StaticStep& end = made.steps.back();
  run.curves.add(0.0, end.quantities);
  run.frames = 1;
  run.dofs_start = made.steps.front().dofs;
  run.dofs_max = run.dofs_end = end.dofs;
  run.dofs_mean = end.dofs;
  run.refined = made.refined;
  run.eta_max = end.eta;
  for (const StaticStep& step : made.steps) {
    run.unconverged += !step.converged;
    run.iterations += step.iterations;
    run.work += static_cast<double>(step.dofs) * (1.0 + step.iterations);
  }
  return !stopped;
}

bool pass(const Scene& scene, bool first, const InstantVisitor& instants, const std::function<bool(double)>& go_on,
          MeasuredRun& run) {
  return (scene.dynamics ? pass_moving : pass_static)(scene, first, instants, go_on, run);
}

/// Passes until they are enough. What went wrong, or nothing.
std::string pass_often(const Scene& scene, const MeasureOptions& options, const InstantVisitor& instants,
                       MeasuredRun& run) {
  double spent = 0.0;  // [s]
  for (int number = 0; number < options.passes_most; ++number) {
    if (number >= options.passes_least && spent >= options.seconds) break;
    try {
      if (!pass(scene, number == 0, instants, options.go_on, run)) {
        return "stopped";
      }
    } catch (const SceneError&) {
      throw;
    } catch (const std::exception& error) {
      const std::size_t frame = number == 0 ? static_cast<std::size_t>(run.frames) + 1 : run.frame_ms.back().size() + 1;
      return "frame " + std::to_string(frame) + " could not be computed: " + error.what();
    }
    spent += 1e-3 * std::accumulate(run.frame_ms.back().begin(), run.frame_ms.back().end(), 0.0);
  }
  if (run.unconverged > 0)
    return std::to_string(run.unconverged) + " of " + std::to_string(run.frames) + " frames did not converge";
  return {};
}

/// The same; what went wrong is told in the run.
void make_passes(const Scene& scene, const MeasureOptions& options, const InstantVisitor& instants, MeasuredRun& run) {
  run.why_incomplete = pass_often(scene, options, instants, run);
  run.complete = run.why_incomplete.empty();
  run.dofs_mean /= std::max(1, run.frames);
  run.peak_memory_mb = peak_memory_mb();
}

bool same_places(const StrainSamples& a, const StrainSamples& b) {
  return a.places.cols() == b.places.cols() && a.places == b.places;
}

}  // namespace

double relative_distance(double difference, double size) {
  if (difference == 0.0 && size == 0.0) return 0.0;
  return size > 0.0 ? std::sqrt(difference / size) : std::nan("");
}

void require_start(const Scene& scene) {
  if (scene.dynamics)
    (void)MovingSimulation(scene);
  else
    (void)run_static(scene, [](const StaticView&) { return false; });
}

MeasuredRun measure_run(const Scene& scene, const MeasureOptions& options) {
  MeasuredRun run;
  InstantVisitor instants;
  StrainDistance sum;
  std::vector<std::optional<MaterialPoint>> points;
  if (options.reference) {
    for (const StrainInstant& instant : options.reference->instants) instants.times.push_back(instant.time);
    instants.visit = [&](std::size_t i, const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& u) {
      const StrainSamples& samples = options.reference->instants[i].strains;
      Material norm = scene.material;
      norm.kinematics = options.reference->kinematics;
      // A reference whose mesh follows the solution has other places at each instant.
      if (i == 0 || !same_places(samples, options.reference->instants[i - 1].strains))
        points = locate_samples(forest.base(), samples);
      const StrainDistance distance = strain_distance(samples, points, forest, mesh, u, norm);
      sum.difference += distance.difference;
      sum.size += distance.size;
      run.left_out = std::max(run.left_out, distance.left_out);
    };
  }
  make_passes(scene, options, instants, run);
  run.reference_size = sum.size;
  if (options.reference && run.complete) {
    run.errors = errors_against(options.reference->curves, run.curves, scene.quantities);
    run.errors["energy_norm"] = run.left_out < 1.0 ? relative_distance(sum.difference, sum.size) : std::nan("");
  }
  return run;
}

std::optional<ReferenceRun> record_reference(const Scene& scene, const std::vector<double>& times, std::string& why,
                                             const std::function<bool(double)>& go_on) {
  ReferenceRun reference;
  reference.kinematics = scene.material.kinematics;
  InstantVisitor instants;
  instants.times = scene.dynamics ? times : std::vector<double>{0.0};
  instants.visit = [&](std::size_t i, const RefinementForest&, const Mesh& mesh, const Eigen::Matrix3Xd& u) {
    reference.instants.push_back({instants.times[i], sample_strains(mesh, u)});
  };
  MeasureOptions options;
  options.go_on = go_on;
  MeasuredRun run;
  make_passes(scene, options, instants, run);
  why = run.why_incomplete;
  if (!run.complete) return {};
  reference.curves = std::move(run.curves);
  return reference;
}

std::vector<double> instants_of(const Scene& scene, double step, int count) {
  if (!scene.dynamics) return {0.0};
  const double end = frame_count(*scene.dynamics) * scene.dynamics->time_step;
  std::vector<double> times;
  for (int i = 1; i <= count; ++i) {
    const double time = step * std::floor(end * i / count / step + 1e-9);
    if (time > 0.0 && (times.empty() || time > times.back())) times.push_back(time);
  }
  if (times.empty()) times.push_back(end);
  return times;
}

}  // namespace finegauge
