#include "benchmarks/program/moving_simulation.hpp"

#include <stdexcept>
#include <utility>

#include "benchmarks/program/allocation_counter.hpp"
#include "benchmarks/program/processor_time.hpp"
#include "benchmarks/program/quantity_points.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/scene_error.hpp"
#include "core/scene/start_forest.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {

MovingSimulation::Motion MovingSimulation::start(const Scene& scene, StageClock stage_clock) {
  RefinementForest forest = start_forest(scene);
  if (!scene.needle) {
    MotionProblem problem = motion_problem(scene);
    problem.stage_clock = stage_clock;
    Tissue tissue = start_tissue(std::move(forest), problem);
    return FreeMotion{std::move(problem), std::move(tissue), {}};
  }
  InsertionProblem problem = insertion_problem(scene);
  problem.motion.stage_clock = stage_clock;
  try {
    Insertion insertion = start_insertion(std::move(forest), problem);
    return NeedleMotion{std::move(problem), std::move(insertion)};
  } catch (const std::invalid_argument& error) {
    throw SceneError(scene.file + ": needle: " + error.what());
  }
}

MovingSimulation::MovingSimulation(const Scene& scene, StageClock stage_clock)
    : scene_(scene),
      motion_(start(scene, stage_clock)),
      points_(quantity_points(scene, tissue().forest.base())),
      planned_frames_(frame_count(scene.dynamics.value())) {}

MotionFrame MovingSimulation::advance() {
  MotionFrame frame;
  const std::optional<std::int64_t> allocations = heap_allocations();
  const double processor_before = processor_ms();
  Stopwatch watch;
  if (auto* free = std::get_if<FreeMotion>(&motion_)) {
    frame.report.frame = advance_frame(free->problem, free->tissue, free->energy);
  } else {
    auto& [problem, insertion] = std::get<NeedleMotion>(motion_);
    frame.report = scene_.dynamics->check_popping ? advance_checked(problem, insertion, mesh_changes_)
                                                  : advance_frame(problem, insertion);
  }
  frame.frame_ms = watch.lap();
  frame.processor_ms = processor_ms() - processor_before;
  if (allocations) frame.heap_allocations = *heap_allocations() - *allocations;
  frame.quantities = frame_quantities();
  return frame;
}

const Tissue& MovingSimulation::tissue() const {
  if (const auto* free = std::get_if<FreeMotion>(&motion_)) return free->tissue;
  return std::get<NeedleMotion>(motion_).insertion.tissue;
}

const Insertion* MovingSimulation::insertion() const {
  const auto* needle = std::get_if<NeedleMotion>(&motion_);
  return needle ? &needle->insertion : nullptr;
}

double MovingSimulation::buckling_load() const {
  const auto* needle = std::get_if<NeedleMotion>(&motion_);
  return needle ? buckling_load_fixed_free(needle->problem.needle) : 0.0;
}

std::vector<double> MovingSimulation::state() const {
  const Insertion* with_needle = insertion();
  return with_needle ? state_values(*with_needle) : state_values(tissue());
}

Json MovingSimulation::frame_quantities() const {
  Json values = Json::object();
  const Tissue& body = tissue();
  for (std::size_t i = 0; i < scene_.quantities.size(); ++i) {
    const QuantityOfInterest& quantity = scene_.quantities[i];
    if (quantity.kind == QuantityKind::energy) values[quantity.name] = strain_energy_product(body.mesh.d, body.state.u);
    if (!points_[i]) continue;
    const Mesh& mesh = body.mesh.d.mesh;
    const Eigen::Vector3d u = interpolate(mesh, body.state.u, find_leaf(body.forest, mesh, *points_[i]));
    values[quantity.name] = {u.x(), u.y(), u.z()};
  }
  return values;
}

}  // namespace finegauge
