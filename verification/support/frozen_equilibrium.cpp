#include "verification/support/frozen_equilibrium.hpp"

#include <algorithm>
#include <cmath>

namespace finegauge {
namespace {

constexpr int most_iterations = 60;
constexpr double smallest_error = 1e-9;
constexpr double steps_to_rest = 1e6;

}  // namespace

FrozenEquilibrium frozen_equilibrium(const InsertionProblem& problem, const Insertion& insertion) {
  const MotionProblem& motion = problem.motion;
  const double tau = steps_to_rest * motion.time_step;
  TissueMesh mesh = insertion.tissue.mesh;
  if (!insertion.tissue.release.empty()) mesh.loads = insertion.tissue.release.own_loads;
  TissueState start = insertion.tissue.state;
  start.v.setZero();
  NeedleState needle = insertion.needle;
  needle.velocities.setZero();
  needle.spins.setZero();
  NeedleContacts contacts = insertion.contacts;
  NeedleSystem needle_system = start_needle_system(problem.needle);
  const TissueView view{insertion.tissue.forest, mesh.d.mesh, mesh.d.hanging, start.u, start.v};
  const auto begun =
      contacts.begin_step(problem.needle, needle, view, Eigen::Vector3d::Zero(), needle_system.axes, tau);
  std::vector<ContactRows> rows(begun.begin(), begun.end());
  const double entry = contacts.entry_length(problem.needle);
  // The step that ends now, so that supports and base are where they are now.
  const double time = insertion.tissue.time - tau;

  FrozenEquilibrium result;
  StepSolver solver(motion.solver);
  TissueSystem system;
  Eigen::VectorXd tissue_end, needle_end;
  while (result.iterations < most_iterations && !result.converged) {
    const bool first = result.iterations++ == 0;
    if (first)
      assemble_step(mesh, motion.tissue, start, time, tau, system);
    else
      assemble_newton_step(mesh, motion.tissue, start, tissue_end, time, tau, system);
    assemble_needle_step(problem.needle, problem.drive, needle, entry, motion.tissue.gravity,
                         first ? nullptr : &needle_end, time, tau, needle_system);
    if (first) tissue_end = system.velocity, needle_end = needle_system.velocity;
    tissue_end += system.prescribed;
    needle_end += needle_system.prescribed;
    solver.set_matrix(system.A, !first);
    const Interaction solved = solve_interaction({.A = system.A,
                                                  .b = system.b,
                                                  .supports = mesh.d.supports,
                                                  .tissue_velocity = tissue_end,
                                                  .needle_A = needle_system.held_A,
                                                  .needle_b = needle_system.held_b,
                                                  .held = needle_system.held,
                                                  .needle_velocity = needle_end,
                                                  .points = rows,
                                                  .tau = tau,
                                                  .reference_speed = problem.contact.cut_advance / tau},
                                                 problem.interaction, solver);
    tissue_end += solved.tissue;
    needle_end += solved.needle;
    if (!tissue_end.allFinite()) return result;
    Eigen::VectorXd impulse = Eigen::VectorXd::Zero(system.b.size());
    double change = 0.0, largest = 0.0;
    for (std::size_t p = 0; p < rows.size(); ++p) {
      const Eigen::Vector3d& lambda = solved.points[p].lambda;
      change = std::max(change, (lambda - rows[p].lambda).norm());
      largest = std::max(largest, lambda.norm());
      rows[p].lambda = lambda;
      for (std::size_t i = 0; i < rows[p].tissue.node.size(); ++i)
        impulse.segment<3>(3 * rows[p].tissue.node[i]) -= rows[p].tissue.weight[i] * (rows[p].frame * lambda);
    }
    TissueState end = start;
    update(mesh, tissue_end - system.velocity, tau, end);
    result.error = out_of_balance(mesh, motion.tissue, end, system.velocity, impulse, tau, time).error();
    result.converged = solved.converged && result.error <= smallest_error && change <= 1e-8 * largest;
  }
  for (const ContactRows& row : rows)
    result.force += (row.lateral == LateralLaw::coulomb ? (row.frame * row.lambda).dot(insertion.axis)
                                                        : row.lambda.x() * row.frame.col(0).dot(insertion.axis)) /
                    tau;
  return result;
}

Insertion copy_of(const Insertion& insertion, const InsertionProblem& problem) {
  const Tissue& tissue = insertion.tissue;
  return {.tissue = {.forest = tissue.forest,
                     .mesh = tissue.mesh,
                     .state = tissue.state,
                     .estimate = tissue.estimate,
                     .history = tissue.history,
                     .release = tissue.release,
                     .system = {},
                     .solver = StepSolver(problem.motion.solver),
                     .largest_energy = tissue.largest_energy,
                     .mesh_changed = true,
                     .time = tissue.time,
                     .frame = tissue.frame},
          .needle = insertion.needle,
          .needle_system = insertion.needle_system,
          .contacts = insertion.contacts,
          .places = {},
          .axis = insertion.axis,
          .first_touch_travel = insertion.first_touch_travel,
          .energy = insertion.energy};
}

}  // namespace finegauge
