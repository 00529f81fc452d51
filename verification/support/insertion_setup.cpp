#include "verification/support/insertion_setup.hpp"

#include <utility>

namespace finegauge {

InsertionSetup held_insertion() {
  InsertionSetup setup;
  setup.cells = {6, 3, 3};
  setup.kinematics = Kinematics::linear;
  setup.solver.linear.relative_residual = 1e-12;
  setup.interaction.tolerance = 1e-11;
  setup.contact.puncture_strength = 2.0;
  setup.contact.cut_strength = 3.0;
  setup.contact.clamping = 1000.0;
  setup.strokes = {{{0.0066, 0.0, 0.0}, 0.66}, {{0.0, 0.0, 0.0}, 2.0}};
  return setup;
}

InsertionCase insertion_case(const InsertionSetup& setup) {
  const UnitSystem& unit = setup.units;
  BoxMeshOptions box;
  box.size = unit.length * setup.size;
  box.cells = setup.cells;
  box.removed = setup.removed;

  InsertionProblem problem;
  MotionProblem& motion = problem.motion;
  TissueProblem& tissue = motion.tissue;
  tissue.material.youngs_modulus = setup.youngs_modulus * unit.pressure();
  tissue.material.poisson_ratio = setup.poisson_ratio;
  tissue.material.kinematics = setup.kinematics;
  tissue.density = setup.density * unit.mass / (unit.length * unit.length * unit.length);
  tissue.stiffness_damping = setup.stiffness_damping * unit.time;
  for (const std::string& surface : setup.clamped) tissue.supports.push_back({surface, {}, {}, {}});
  motion.time_step = setup.time_step * unit.time;
  motion.step = setup.step;
  motion.solver = setup.solver;
  motion.estimate_error = setup.estimate_error;
  motion.adapt = setup.adapt;

  NeedleProperties properties = setup.needle;
  properties.youngs_modulus *= unit.pressure();
  properties.radius *= unit.length;
  properties.density *= unit.mass / (unit.length * unit.length * unit.length);
  const Eigen::Vector3d tip = setup.entry - Eigen::Vector3d(setup.start_distance, 0.0, 0.0);
  problem.needle = straight_needle(properties, unit.length * (tip - Eigen::Vector3d(setup.needle_length, 0.0, 0.0)),
                                   unit.length * tip, setup.elements);
  for (Stroke stroke : setup.strokes) {
    stroke.displacement *= unit.length;
    stroke.duration *= unit.time;
    problem.drive.strokes.push_back(stroke);
  }
  ContactRules& contact = problem.contact = setup.contact;
  contact.puncture_strength *= unit.force();
  contact.cut_strength *= unit.force();
  contact.cut_advance *= unit.length;
  contact.clamping *= unit.force() / unit.length;
  contact.coupling_radius *= unit.length;
  problem.interaction = setup.interaction;
  return {std::move(problem), RefinementForest(box_mesh(box))};
}

int InsertionRun::unconverged() const {
  int count = 0;
  for (const InsertionReport& report : frames) count += !report.frame.converged;
  return count;
}

std::vector<ContactEvent> InsertionRun::events(ContactEventKind kind) const {
  std::vector<ContactEvent> found;
  for (const InsertionReport& report : frames)
    for (const ContactEvent& event : report.events)
      if (event.kind == kind) found.push_back(event);
  return found;
}

InsertionRun run_insertion(const InsertionSetup& setup, int frames) {
  InsertionCase made = insertion_case(setup);
  InsertionRun run{{}, start_insertion(std::move(made.forest), made.problem)};
  for (int k = 0; k < frames; ++k) run.frames.push_back(advance_frame(made.problem, run.insertion));
  return run;
}

}  // namespace finegauge
