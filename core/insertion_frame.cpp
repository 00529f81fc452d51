#include "core/insertion_frame.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/mesh/body_location.hpp"

namespace finegauge {
namespace {

TissueView view(const Tissue& tissue) {
  return {tissue.forest, tissue.mesh.d.mesh, tissue.mesh.d.hanging, tissue.state.u, tissue.state.v};
}

/// Adds Jᵀ λ on the tissue, reduced, and on the needle [N s].
void add_constraint_impulses(std::span<const ContactRows> rows, std::span<const ContactOutcome> outcomes,
                             Eigen::VectorXd& tissue, Eigen::VectorXd& needle) {
  for (std::size_t p = 0; p < rows.size(); ++p) {
    const Eigen::Vector3d impulse = rows[p].frame * outcomes[p].lambda;
    for (std::size_t i = 0; i < rows[p].tissue.node.size(); ++i)
      tissue.segment<3>(3 * rows[p].tissue.node[i]) -= rows[p].tissue.weight[i] * impulse;
    needle.segment<12>(6 * rows[p].element) += rows[p].needle.transpose() * impulse;
  }
}

/// Whether a force of the tip ends with the event, within a frame. A touch, a stick and a retraction begin or go on
/// from zero, and a slip from the bound.
bool ends_a_force(const ContactEvent& event) {
  return event.kind == ContactEventKind::puncture || event.kind == ContactEventKind::cut ||
         event.kind == ContactEventKind::release || event.kind == ContactEventKind::exit;
}

/// The tissue's Jᵀ λ on another mesh of the forest, with the rows' points at their material places [N s].
Eigen::VectorXd constraint_impulse_on(const TissueMesh& mesh, const RefinementForest& forest,
                                      std::span<const ContactRows> rows, std::span<const ContactOutcome> outcomes,
                                      std::span<const SpreadPoint> places) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.d.dof_count());
  ReducedWeights weights;
  for (std::size_t p = 0; p < rows.size(); ++p) {
    find_reduced_weights(forest, mesh.d.mesh, mesh.d.hanging, places[p], weights);
    const Eigen::Vector3d impulse = rows[p].frame * outcomes[p].lambda;
    for (std::size_t i = 0; i < weights.node.size(); ++i)
      sum.segment<3>(3 * weights.node[i]) -= weights.weight[i] * impulse;
  }
  return sum;
}

/// What violations are compared with [m/s]: the base's fastest speed, at least 1e-4 d_c a step for needles that rest.
/// The floor is far below any speed that matters and far above round-off of positions: at the tolerance of 1e-8 a point
/// is held to 1e-12 d_c a step. The whole speed times a thousand or over a thousand costs 12 % fewer or 2 % more
/// iterations in an insertion into a block, and moves forces by 0.3 % of the largest, in frames where the contact
/// changes.
double reference_speed(const InsertionProblem& problem) {
  return std::max(fastest_speed(problem.drive), 1e-4 * problem.contact.cut_advance / problem.motion.time_step);
}

/// The constrained implicit step from `tissue.state` and `needle`: one linearization as the paper has it, or Newton
/// until the equilibrium error is met. `before` is a copy of `tissue.state`.
struct ConstrainedStep {
  Interaction interaction;                         // of the last linearization
  Eigen::VectorXd tissue_start, tissue_end;        // v, reduced [m/s]
  Eigen::VectorXd needle_start, needle_end;        // v, in axis components
  Eigen::VectorXd tissue_impulse, needle_impulse;  // Jᵀ λ [N s]
};

ConstrainedStep solve_step(const InsertionProblem& problem, std::span<const ContactRows> rows,
                           const TissueState& before, Insertion& insertion, FrameReport& frame, Stopwatch& watch) {
  const MotionProblem& motion = problem.motion;
  const double tau = motion.time_step;
  Tissue& tissue = insertion.tissue;
  const double time = tissue.time;
  TissueSystem& system = tissue.system;
  NeedleSystem& needle_system = insertion.needle_system;
  const double entry = insertion.contacts.entry_length(problem.needle);
  ConstrainedStep step;
  for (int iteration = 0;; ++iteration) {
    if (iteration == 0)
      assemble_step(tissue.mesh, motion.tissue, before, time, tau, system);
    else
      assemble_newton_step(tissue.mesh, motion.tissue, before, step.tissue_end, time, tau, system);
    frame.times.assemble_ms += watch.lap();
    assemble_needle_step(problem.needle, problem.drive, insertion.needle, entry, motion.tissue.gravity,
                         iteration == 0 ? nullptr : &step.needle_end, time, tau, needle_system);
    if (iteration == 0) {
      step.tissue_start = step.tissue_end = system.velocity;
      step.needle_start = step.needle_end = needle_system.velocity;
    }
    step.tissue_end += system.prescribed;
    step.needle_end += needle_system.prescribed;
    frame.times.needle_ms += watch.lap();
    tissue.solver.set_matrix(system.A, !std::exchange(tissue.mesh_changed, false));
    step.interaction = solve_interaction({.A = system.A,
                                          .b = system.b,
                                          .supports = tissue.mesh.d.supports,
                                          .tissue_velocity = step.tissue_end,
                                          .needle_A = needle_system.held_A,
                                          .needle_b = needle_system.held_b,
                                          .held = needle_system.held,
                                          .needle_velocity = step.needle_end,
                                          .points = rows,
                                          .tau = tau,
                                          .reference_speed = reference_speed(problem)},
                                         problem.interaction, tissue.solver);
    step.tissue_end += step.interaction.tissue;
    step.needle_end += step.interaction.needle;
    frame.converged = frame.converged && step.interaction.converged;
    frame.solver_iterations += step.interaction.linear_iterations;
    frame.uzawa_iterations += step.interaction.iterations;
    ++frame.newton_iterations;
    frame.times.solve_ms += watch.lap();

    step.tissue_impulse.setZero(step.tissue_end.size());
    step.needle_impulse.setZero(step.needle_end.size());
    add_constraint_impulses(rows, step.interaction.points, step.tissue_impulse, step.needle_impulse);
    if (iteration > 0) tissue.state = before;
    update(tissue.mesh, step.tissue_end - step.tissue_start, tau, tissue.state);
    const OutOfBalance left =
        out_of_balance(tissue.mesh, motion.tissue, tissue.state, step.tissue_start, step.tissue_impulse, tau, time);
    frame.equilibrium_error = left.error();
    frame.times.update_ms += watch.lap();
    if (motion.step.newton_iterations == 1 ||
        is_balanced(left, motion.step.newton_residual, tissue.mesh, tissue.state, tau))
      break;
    if (frame.newton_iterations >= motion.step.newton_iterations) frame.converged = false;
    if (!frame.converged) break;
  }
  return step;
}

std::string in_words(const ChainMeeting& meeting, const Needle& needle) {
  const std::string node = std::to_string(meeting.point), last = std::to_string(needle.node_count() - 1);
  switch (meeting.kind) {
    case ChainMeeting::Kind::on_surface:
      return "its node " + node + " of 0 to " + last + " lies on the body's surface";
    case ChainMeeting::Kind::inside:
      return "its node " + node + " of 0 to " + last + " lies in the body";
    case ChainMeeting::Kind::enters:
      break;
  }
  return "it enters the body between its nodes " + node + " and " + std::to_string(meeting.point + 1) + " of 0 to " +
         last;
}

}  // namespace

Insertion start_insertion(RefinementForest forest, const InsertionProblem& problem) {
  const Needle& needle = problem.needle;
  Insertion insertion{.tissue = start_tissue(std::move(forest), problem.motion),
                      .needle = needle_at_rest(needle),
                      .needle_system = start_needle_system(needle),
                      .contacts = NeedleContacts(problem.contact),
                      .places = {},
                      .axis = Eigen::Vector3d::Zero(),
                      .first_touch_travel = {},
                      .energy = {}};
  insertion.axis = insertion.needle_system.axes.col(0);
  const Tissue& tissue = insertion.tissue;
  if (const auto meeting =
          chain_meeting(tissue.forest.base(), tissue.mesh.d.mesh, tissue.state.u, needle.rest_positions))
    throw std::invalid_argument("the needle starts in the tissue: " + in_words(*meeting, needle));
  return insertion;
}

InsertionReport advance_frame(const InsertionProblem& problem, Insertion& insertion) {
  const MotionProblem& motion = problem.motion;
  const double tau = motion.time_step;
  Tissue& tissue = insertion.tissue;
  InsertionReport report;
  FrameReport& frame = report.frame;
  if (tissue.releasing()) fade(tissue.release, tissue.mesh);
  frame = begin_report(tissue);
  Stopwatch watch(motion.stage_clock);

  const Eigen::Vector3d base_advance =
      base_displacement(problem.drive, tissue.time + tau) - base_displacement(problem.drive, tissue.time);
  const std::span<const ContactRows> rows = insertion.contacts.begin_step(
      problem.needle, insertion.needle, view(tissue), base_advance, insertion.needle_system.axes, tau);
  report.contact_points = static_cast<int>(rows.size());
  frame.times.contact_ms += watch.lap();

  const TissueState before = tissue.state;
  const ConstrainedStep step = solve_step(problem, rows, before, insertion, frame, watch);
  frame.residual = step.interaction.residual;
  frame.violation = step.interaction.violation;

  const Eigen::VectorXd needle_dv = step.needle_end - step.needle_start;
  const NeedleSystem& needle_system = insertion.needle_system;
  // With Newton the system is the last linearization's: its own dv is what its solve added.
  const Eigen::VectorXd reactions =
      hold_reactions(needle_system, step.needle_end - needle_system.velocity, step.needle_impulse);
  advance_needle(needle_system, step.needle_end, tau, insertion.needle);
  ++tissue.frame;
  tissue.time = tissue.frame * tau;
  frame.time = tissue.time;
  frame.times.update_ms += watch.lap();

  // Where the frame's constraints act, before transitions move the points.
  const bool releases = motion.adapt && motion.adapt->release > 1;
  if (releases) insertion.contacts.copy_places(insertion.places);
  insertion.contacts.end_step(problem.needle, insertion.needle, view(tissue), step.interaction.points, tissue.time, tau,
                              problem.interaction.tolerance * reference_speed(problem));
  frame.times.contact_ms += watch.lap();

  EnergyLedger& energy = insertion.energy;
  add_tissue_work(motion, tissue, before, step.tissue_impulse, energy);
  energy.work += reactions.dot(step.needle_end);
  for (int node = 0; node < problem.needle.node_count(); ++node)
    energy.work += tau * needle_system.mass[6 * node] *
                   motion.tissue.gravity.dot(needle_system.axes * step.needle_end.segment<3>(6 * node));
  energy.dissipated +=
      insertion.contacts.dissipated() + numerical_dissipation(needle_system, needle_dv, step.needle_end);

  const ContactForces forces = insertion.contacts.forces(insertion.axis, tau);
  report.tip_force = forces.tip;
  report.shaft_force = forces.shaft;
  report.across_force = forces.across;
  report.tip_lateral_force = forces.tip_lateral;
  report.force = forces.total();
  report.base_force = reactions[0] / tau;
  report.insertion_depth = insertion.contacts.inserted_length();
  report.tip_state = insertion.contacts.tip_state();
  report.events.assign(insertion.contacts.events().begin(), insertion.contacts.events().end());
  const int tip = problem.needle.node_count() - 1;
  const double travel =
      insertion.axis.dot(insertion.needle.positions.col(tip) - problem.needle.rest_positions.col(tip));
  for (const ContactEvent& event : report.events)
    if (event.kind == ContactEventKind::touch && !insertion.first_touch_travel) insertion.first_touch_travel = travel;
  report.tip_displacement = insertion.first_touch_travel ? travel - *insertion.first_touch_travel : 0.0;
  frame.times.update_ms += watch.lap();

  EndedStep ended{before.v, step.tissue_impulse};
  ended.time = (tissue.frame - 1) * tau;
  ended.forces_jump = std::any_of(report.events.begin(), report.events.end(), ends_a_force);
  if (releases)
    ended.constraint_on_mesh = [&](const TissueMesh& mesh) {
      return constraint_impulse_on(mesh, tissue.forest, rows, step.interaction.points, insertion.places);
    };
  follow_solution(motion, ended, tissue, energy, frame);
  watch.lap();
  const TissueEnergy stored = tissue_energy(tissue.mesh, tissue.state, tissue.time);
  energy.kinetic = stored.kinetic + needle_kinetic_energy(problem.needle, insertion.needle);
  energy.elastic = stored.elastic + needle_energy(problem.needle, insertion.needle);
  close(energy);
  frame.energy = energy;
  frame.times.update_ms += watch.lap();
  return report;
}

std::vector<double> state_values(const Insertion& insertion) {
  std::vector<double> values = state_values(insertion.tissue);
  const NeedleState& needle = insertion.needle;
  for (int node = 0; node < static_cast<int>(needle.positions.cols()); ++node) {
    values.insert(values.end(), needle.positions.col(node).begin(), needle.positions.col(node).end());
    values.insert(values.end(), needle.velocities.col(node).begin(), needle.velocities.col(node).end());
    values.insert(values.end(), needle.spins.col(node).begin(), needle.spins.col(node).end());
    const auto R = needle.rotations[node].reshaped();
    values.insert(values.end(), R.begin(), R.end());
  }
  insertion.contacts.append_state(values);
  return values;
}

}  // namespace finegauge
