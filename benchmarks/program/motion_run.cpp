#include "benchmarks/program/motion_run.hpp"

#include <algorithm>
#include <exception>
#include <stdexcept>

#include "benchmarks/program/allocation_counter.hpp"
#include "benchmarks/program/quantity_points.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/scene_error.hpp"
#include "core/scene/start_forest.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {
namespace {

Json frame_quantities(const Scene& scene, const std::vector<std::optional<MaterialPoint>>& points,
                      const Tissue& tissue) {
  Json values = Json::object();
  for (std::size_t i = 0; i < scene.quantities.size(); ++i) {
    const QuantityOfInterest& quantity = scene.quantities[i];
    if (quantity.kind == QuantityKind::energy)
      values[quantity.name] = strain_energy_product(tissue.mesh.d, tissue.state.u);
    if (!points[i]) continue;
    const Mesh& mesh = tissue.mesh.d.mesh;
    const Eigen::Vector3d u = interpolate(mesh, tissue.state.u, find_leaf(tissue.forest, mesh, *points[i]));
    values[quantity.name] = {u.x(), u.y(), u.z()};
  }
  return values;
}

std::vector<std::string> notes_on_problem(const Scene& scene, const Tissue& tissue) {
  std::vector<std::string> notes = scene.notes;
  const Discretization& d = tissue.mesh.d;
  int free_motions = 0;
  for (const BodyFreedom& body : free_rigid_motions(tissue.forest.topology(), d.mesh, d.hanging, d.supports, d.springs))
    free_motions = std::max(free_motions, body.free_motions);
  const bool pushed = !scene.dynamics->gravity.isZero(0.0) || !scene.body_force.isZero(0.0) || !scene.loads.empty();
  if (free_motions > 0 && (scene.needle || pushed))
    notes.push_back("the supports leave " + std::to_string(free_motions) +
                    " rigid motions of the body free: it gives way to " + (scene.needle ? "the needle" : "its loads") +
                    " as a whole");
  if (scene.needle &&
      fastest_speed(scene.needle->drive) * scene.dynamics->time_step > 0.25 * scene.needle->contact.cut_advance)
    notes.emplace_back(
        "the base advances by more than a quarter of cut_advance in a frame: the tip is held a whole frame at each "
        "place where it sticks, and its force overshoots; shorten time_step");
  if (scene.needle && (scene.needle->tip - scene.needle->base).norm() >
                          (1.0 + 1e-9) * scene.needle->elements * scene.needle->contact.cut_advance)
    notes.emplace_back(
        "the needle's elements are longer than cut_advance: the points along the shaft outnumber what can bend between "
        "them, and may lock it; more elements, or longer cuts");
  if (scene.material.kinematics == Kinematics::linear)
    notes.emplace_back("linear kinematics: cells that turn by more than a few degrees swell; corotational ones do not");
  if (scene.dynamics->step.newton_iterations == 1 && scene.material.kinematics == Kinematics::corotational)
    notes.emplace_back("one linear solve a frame: what it leaves of the implicit step is equilibrium_error");
  if (scene.dynamics->check_popping)
    notes.emplace_back(
        "check_popping: frame times and allocations include the copies that are followed beside the run");
  return notes;
}

/// The frames of either kind of body; `advance` makes one and leaves it in its argument.
template <class Advance>
void run_frames(const Scene& scene, const Tissue& tissue, const Insertion* insertion, Advance advance,
                const std::vector<std::optional<MaterialPoint>>& points, const MotionObserver& observer,
                MotionRun& run) {
  run.frames.reserve(static_cast<std::size_t>(run.planned_frames));
  for (int i = 0; i < run.planned_frames; ++i) {
    MotionFrame frame;
    const std::optional<std::int64_t> allocations = heap_allocations();
    Stopwatch watch;
    try {
      advance(frame.report);
    } catch (const std::exception& error) {
      run.failed = true;
      run.stopped_because = "frame " + std::to_string(i + 1) + " could not be computed: " + error.what();
      return;
    }
    frame.frame_ms = watch.lap();
    if (allocations) frame.heap_allocations = *heap_allocations() - *allocations;
    frame.quantities = frame_quantities(scene, points, tissue);
    run.frames.push_back(std::move(frame));
    const bool last = i + 1 == run.planned_frames;
    const bool go_on = observer({run.frames.back(), tissue, insertion, run.planned_frames, last});
    if (!go_on && !last) {
      run.stopped_because = "interrupted";
      return;
    }
  }
  run.stopped_because = "the duration is over";
}

}  // namespace

MotionRun run_motion(const Scene& scene, const MotionObserver& observer) {
  RefinementForest forest = start_forest(scene);
  const std::vector<std::optional<MaterialPoint>> points = quantity_points(scene, forest.base());
  MotionRun run;
  run.planned_frames = frame_count(scene.dynamics.value());
  if (!scene.needle) {
    const MotionProblem problem = motion_problem(scene);
    Tissue tissue = start_tissue(std::move(forest), problem);
    EnergyLedger energy;
    run.notes = notes_on_problem(scene, tissue);
    run_frames(
        scene, tissue, nullptr, [&](InsertionReport& report) { report.frame = advance_frame(problem, tissue, energy); },
        points, observer, run);
    run.final_state = state_values(tissue);
    return run;
  }
  const InsertionProblem problem = insertion_problem(scene);
  run.buckling_load = buckling_load_fixed_free(problem.needle);
  std::optional<Insertion> insertion;
  try {
    insertion.emplace(start_insertion(std::move(forest), problem));
  } catch (const std::invalid_argument& error) {
    throw SceneError(scene.file + ": needle: " + error.what());
  }
  run.notes = notes_on_problem(scene, insertion->tissue);
  run_frames(
      scene, insertion->tissue, &*insertion,
      [&](InsertionReport& report) {
        report = scene.dynamics->check_popping ? advance_checked(problem, *insertion, run.mesh_changes)
                                               : advance_frame(problem, *insertion);
      },
      points, observer, run);
  run.final_state = state_values(*insertion);
  return run;
}

}  // namespace finegauge
