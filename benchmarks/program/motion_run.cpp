#include "benchmarks/program/motion_run.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "benchmarks/program/static_notes.hpp"

namespace finegauge {
namespace {

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

}  // namespace

MotionRun run_motion(const Scene& scene, const MotionObserver& observer, StageClock stage_clock) {
  MovingSimulation simulation(scene, stage_clock);
  MotionRun run;
  run.planned_frames = simulation.planned_frames();
  run.buckling_load = simulation.buckling_load();
  run.notes = notes_on_problem(scene, simulation.tissue());
  run.stopped_because = "the duration is over";
  run.frames.reserve(static_cast<std::size_t>(run.planned_frames));
  for (int i = 0; i < run.planned_frames; ++i) {
    try {
      run.frames.push_back(simulation.advance());
    } catch (const std::exception& error) {
      run.failed = true;
      run.stopped_because = "frame " + std::to_string(i + 1) + " could not be computed: " + error.what();
      break;
    }
    const bool last = i + 1 == run.planned_frames;
    const MotionView view{run.frames.back(), simulation.tissue(), simulation.insertion(), run.planned_frames, last};
    if (!observer(view) && !last) {
      run.stopped_because = "interrupted";
      break;
    }
  }
  const Tissue& tissue = simulation.tissue();  // where the body is at the end
  for (std::string& note : cell_notes(scene, tissue.mesh.d.mesh, tissue.state.u)) run.notes.push_back(std::move(note));
  run.final_state = simulation.state();
  if (scene.dynamics->check_popping) run.mesh_changes = simulation.mesh_changes();
  return run;
}

}  // namespace finegauge
