#include "benchmarks/audit/comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <numeric>
#include <optional>
#include <random>

#include "benchmarks/measure/measured_run.hpp"
#include "benchmarks/program/frame_statistics.hpp"
#include "benchmarks/program/moving_simulation.hpp"
#include "benchmarks/program/static_run.hpp"
#include "core/scene/scene_error.hpp"

namespace finegauge {
namespace {

constexpr int static_turns = 5, instants = 6;

/// The two scenes of a turn, in random order.
std::array<int, 2> draw_order(std::mt19937_64& random) {
  const int first = static_cast<int>(random() % 2);
  return {first, 1 - first};
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

struct Recording {
  RunCurves curves;
  std::vector<double> ms;
  int unconverged = 0;
};

void finish(const std::array<Recording, 2>& runs, double difference, double size, const Scene& scene,
            SceneComparison& made) {
  made.complete = true;
  made.quantity_change = errors_against(runs[0].curves, runs[1].curves, scene.quantities);
  made.energy_norm_change = relative_distance(difference, size);
  made.mean_ms = mean(runs[0].ms), made.changed_mean_ms = mean(runs[1].ms);
  made.p99_ms = percentile(runs[0].ms, 99), made.changed_p99_ms = percentile(runs[1].ms, 99);
  made.unconverged = runs[0].unconverged, made.changed_unconverged = runs[1].unconverged;
}

SceneComparison compare_moving(const Scene& scene, const Scene& changed, std::uint64_t seed) {
  std::array<MovingSimulation, 2> simulations = {MovingSimulation(scene), MovingSimulation(changed)};
  std::array<Recording, 2> runs;
  std::mt19937_64 random(seed);
  const std::vector<double> times = instants_of(scene, scene.dynamics->time_step, instants);
  const int frames = std::min(simulations[0].planned_frames(), simulations[1].planned_frames());
  double difference = 0.0, size = 0.0;
  std::size_t next = 0;
  for (int i = 0; i < frames; ++i) {
    double time = 0.0;
    for (const int which : draw_order(random)) {
      const auto k = static_cast<std::size_t>(which);
      const MotionFrame frame = simulations[k].advance();
      time = frame.report.frame.time;
      runs[k].curves.add(time, frame.quantities);
      if (scene.needle) {
        runs[k].curves.travel.push_back(frame.report.tip_displacement);
        runs[k].curves.force.push_back(frame.report.force);
        runs[k].curves.tip_force.push_back(frame.report.tip_force);
      }
      runs[k].ms.push_back(frame.processor_ms);
      runs[k].unconverged += !frame.report.frame.converged;
    }
    if (next >= times.size() || time < times[next] - 0.5 * scene.dynamics->time_step) continue;
    ++next;
    const Tissue &one = simulations[0].tissue(), &other = simulations[1].tissue();
    const StrainSamples samples = sample_strains(one.mesh.d.mesh, one.state.u);
    const StrainDistance distance = strain_distance(samples, locate_samples(other.forest.base(), samples), other.forest,
                                                    other.mesh.d.mesh, other.state.u, scene.material);
    difference += distance.difference;
    size += distance.size;
  }
  SceneComparison made;
  finish(runs, difference, size, scene, made);
  return made;
}

SceneComparison compare_static(const Scene& scene, const Scene& changed, std::uint64_t seed) {
  const std::array<const Scene*, 2> scenes = {&scene, &changed};
  std::array<Recording, 2> runs;
  std::mt19937_64 random(seed);
  for (int turn = 0; turn < static_turns; ++turn)
    for (const int which : draw_order(random)) {
      const auto k = static_cast<std::size_t>(which);
      const MeasuredRun run = measure_run(*scenes[k], {});
      if (!run.complete) {
        SceneComparison failed;
        failed.why_incomplete = (which == 0 ? "" : "changed: ") + run.why_incomplete;
        return failed;
      }
      runs[k].ms.push_back(run.frame_ms.front().front());
      runs[k].curves = run.curves;
    }
  SceneComparison made;
  const std::optional<ReferenceRun> first = record_reference(scene, {0.0}, made.why_incomplete);
  if (!first) return made;
  MeasureOptions options;
  options.reference = &*first;
  const MeasuredRun second = measure_run(changed, options);
  if (!second.complete) {
    made.why_incomplete = second.why_incomplete;
    return made;
  }
  finish(runs, 0.0, 0.0, scene, made);
  made.energy_norm_change = second.errors.at("energy_norm");
  return made;
}

}  // namespace

double SceneComparison::largest_change() const {
  double largest = -1.0;
  for (const auto& [name, change] : quantity_change)
    if (std::isfinite(change)) largest = std::max(largest, change);
  return largest < 0.0 ? energy_norm_change : largest;
}

SceneComparison compare_scenes(const Scene& scene, const Scene& changed, std::uint64_t seed) {
  try {
    return (scene.dynamics ? compare_moving : compare_static)(scene, changed, seed);
  } catch (const SceneError&) {
    throw;
  } catch (const std::exception& error) {
    SceneComparison failed;
    failed.why_incomplete = error.what();
    return failed;
  }
}

Json to_json(const SceneComparison& c) {
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  Json json = {{"complete", c.complete},
               {"why_incomplete", c.why_incomplete},
               {"quantity_change", Json::object()},
               {"energy_norm_change", number(c.energy_norm_change)},
               {"mean_ms", number(c.mean_ms)},
               {"changed_mean_ms", number(c.changed_mean_ms)},
               {"p99_ms", number(c.p99_ms)},
               {"changed_p99_ms", number(c.changed_p99_ms)},
               {"unconverged", c.unconverged},
               {"changed_unconverged", c.changed_unconverged}};
  for (const auto& [name, change] : c.quantity_change) json["quantity_change"][name] = number(change);
  return json;
}

SceneComparison scene_comparison(const Json& json) {
  const auto number = [](const Json& value) { return value.is_null() ? std::nan("") : value.get<double>(); };
  SceneComparison c;
  json.at("complete").get_to(c.complete);
  json.at("why_incomplete").get_to(c.why_incomplete);
  for (const auto& [name, change] : json.at("quantity_change").items()) c.quantity_change[name] = number(change);
  c.energy_norm_change = number(json.at("energy_norm_change"));
  c.mean_ms = number(json.at("mean_ms")), c.changed_mean_ms = number(json.at("changed_mean_ms"));
  c.p99_ms = number(json.at("p99_ms")), c.changed_p99_ms = number(json.at("changed_p99_ms"));
  json.at("unconverged").get_to(c.unconverged);
  json.at("changed_unconverged").get_to(c.changed_unconverged);
  return c;
}

}  // namespace finegauge
