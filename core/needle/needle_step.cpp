#include "core/needle/needle_step.hpp"

#include <Eigen/Geometry>

#include "core/needle/centreline.hpp"

namespace finegauge {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

Matrix6 node_turn(const Eigen::Matrix3d& axes) {
  Matrix6 turn = Matrix6::Zero();
  turn.topLeftCorner<3, 3>() = axes;
  turn.bottomRightCorner<3, 3>() = axes;
  return turn;
}

void turn_vectors(const Eigen::Matrix3d& turn, Eigen::VectorXd& values) {
  for (Eigen::Index i = 0; i < values.size(); i += 3) values.segment<3>(i) = (turn * values.segment<3>(i)).eval();
}

void turn_blocks(const Matrix6& turn, std::vector<Matrix6>& blocks) {
  for (Matrix6& block : blocks) block = (turn.transpose() * block * turn).eval();
}

void hold_needle(const Needle& needle, const NeedleDrive& drive, const NeedleState& state, double entry_length,
                 double time, double tau, NeedleSystem& system) {
  const Eigen::Vector3d base = needle.rest_positions.col(0) + base_displacement(drive, time + tau);
  const Eigen::Matrix3d to_axes = system.axes.transpose();
  system.held.assign(needle.node_count(), 0u);
  system.prescribed.setZero(needle.dof_count());
  const auto hold_component = [&](int node, int component, double velocity) {
    system.held[node] |= 1u << component;
    system.prescribed[6 * node + component] = velocity - system.velocity[6 * node + component];
  };
  const Eigen::Vector3d drive_velocity = to_axes * (base - state.positions.col(0)) / tau;
  for (int k = 0; k < 3; ++k) hold_component(0, k, drive_velocity[k]);
  if (!drive.base_turns)
    for (int k = 3; k < 6; ++k) hold_component(0, k, 0.0);
  if (!drive.guided) return;
  const double whole = arc_length(needle, {needle.element_count() - 1, 1.0});
  for (int node = 1; node < needle.node_count(); ++node) {
    const double here = arc_length(needle, {node - 1, 1.0});
    const double element = here - arc_length(needle, {node - 1, 0.0});
    if (entry_length < whole && here > entry_length - element) break;
    // Where the needle is bent at rest the guide leaves it so.
    const Eigen::Vector3d place = base + needle.rest_positions.col(node) - needle.rest_positions.col(0);
    const Eigen::Vector3d velocity = to_axes * (place - state.positions.col(node)) / tau;
    for (int k = 1; k < 3; ++k) hold_component(node, k, velocity[k]);
  }
}

}  // namespace

NeedleSystem start_needle_system(const Needle& needle) {
  NeedleSystem system;
  const Eigen::Vector3d axis =
      (needle.rest_positions.col(needle.node_count() - 1) - needle.rest_positions.col(0)).normalized();
  int smallest;
  axis.cwiseAbs().minCoeff(&smallest);
  const Eigen::Vector3d across = axis.cross(Eigen::Vector3d::Unit(smallest)).normalized();
  system.axes << axis, across, axis.cross(across);
  system.mass = needle_mass(needle);
  return system;
}

void assemble_needle_step(const Needle& needle, const NeedleDrive& drive, const NeedleState& state, double entry_length,
                          const Eigen::Vector3d& gravity, const Eigen::VectorXd* guess, double time, double tau,
                          NeedleSystem& system) {
  const Eigen::VectorXd start = generalized_velocity(state);
  Eigen::VectorXd end_velocity = start;
  NeedleState end = state;
  if (guess) {
    end_velocity = *guess;
    turn_vectors(system.axes, end_velocity);
    set_generalized_velocity(end_velocity, end);
    advance(tau, end);
  }
  system.b = -needle_forces(needle, end);
  for (int node = 0; node < needle.node_count(); ++node)
    system.b.segment<3>(6 * node) += system.mass[6 * node] * gravity;
  system.b *= tau;
  system.A.set_zero(needle.node_count());
  add_material_stiffness(needle, end, tau * tau, system.A);
  if (guess) {
    system.b -= system.mass.cwiseProduct(end_velocity - start);
  } else {
    multiply(system.A, start, system.held_b);  // τ² K v
    system.b -= system.held_b;
  }
  for (int node = 0; node < needle.node_count(); ++node)
    system.A.diagonal[node].diagonal() += system.mass.segment<6>(6 * node);

  const Matrix6 turn = node_turn(system.axes);
  turn_blocks(turn, system.A.diagonal);
  turn_blocks(turn, system.A.upper);
  turn_vectors(system.axes.transpose(), system.b);
  system.velocity = end_velocity;
  turn_vectors(system.axes.transpose(), system.velocity);
  hold_needle(needle, drive, state, entry_length, time, tau, system);

  multiply(system.A, system.prescribed, system.held_b);
  system.held_b = system.b - system.held_b;
  system.held_A = system.A;
  hold(system.held, system.held_A);
  hold(system.held, system.held_b);
}

void advance_needle(const NeedleSystem& system, const Eigen::VectorXd& end_velocity, double tau, NeedleState& state) {
  Eigen::VectorXd global = end_velocity;
  turn_vectors(system.axes, global);
  set_generalized_velocity(global, state);
  advance(tau, state);
}

Eigen::VectorXd hold_reactions(const NeedleSystem& system, const Eigen::VectorXd& dv,
                               const Eigen::VectorXd& constraint_impulse) {
  Eigen::VectorXd reactions;
  multiply(system.A, dv, reactions);
  reactions += constraint_impulse - system.b;
  for (std::size_t node = 0; node < system.held.size(); ++node)
    for (int k = 0; k < 6; ++k)
      if (!(system.held[node] & (1u << k))) reactions[6 * static_cast<Eigen::Index>(node) + k] = 0.0;
  return reactions;
}

double numerical_dissipation(const NeedleSystem& system, const Eigen::VectorXd& dv,
                             const Eigen::VectorXd& end_velocity) {
  Eigen::VectorXd Av;
  multiply(system.A, end_velocity, Av);
  return 0.5 * (system.mass.dot(dv.cwiseAbs2()) + end_velocity.dot(Av) - system.mass.dot(end_velocity.cwiseAbs2()));
}

}  // namespace finegauge
