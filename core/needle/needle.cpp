#include "core/needle/needle.hpp"

#include <Eigen/Geometry>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/needle/rotation_vector.hpp"

namespace finegauge {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void add_element(const Matrix12& K, int e, ChainMatrix& A) {
  A.diagonal[e] += K.topLeftCorner<6, 6>();
  A.upper[e] += K.topRightCorner<6, 6>();
  A.diagonal[e + 1] += K.bottomRightCorner<6, 6>();
}

}  // namespace

Needle chain_of_beams(const BeamSection& section, const Eigen::Matrix3Xd& nodes, const Vector3d& second_axis) {
  if (nodes.cols() < 2) throw std::invalid_argument("a chain of beams needs two nodes or more");
  const Vector3d second = second_axis.normalized();
  Needle needle;
  needle.rest_positions = nodes;
  needle.sections.assign(needle.element_count(), section);
  needle.rest_frames.resize(needle.element_count());
  for (int e = 0; e < needle.element_count(); ++e) {
    const std::string element = "element " + std::to_string(e) + " of a chain of beams ";
    const Vector3d chord = nodes.col(e + 1) - nodes.col(e);
    const double length = chord.norm();
    if (!(length > 0.0 && std::isfinite(length))) throw std::invalid_argument(element + "has no length");
    Matrix3d& frame = needle.rest_frames[e];
    frame.col(0) = chord / length;
    const Vector3d third = frame.col(0).cross(second);
    // The angle in radians; below it the frame would be made of round-off.
    if (!(third.norm() > 1e-8)) throw std::invalid_argument(element + "lies along the second axis");
    frame.col(2) = third.normalized();
    frame.col(1) = frame.col(2).cross(frame.col(0));
  }
  return needle;
}

Needle straight_needle(const NeedleProperties& properties, const Vector3d& base, const Vector3d& tip, int elements) {
  if (elements < 1) throw std::invalid_argument("elements is " + std::to_string(elements) + ", but must be 1 or more");
  Eigen::Matrix3Xd nodes(3, elements + 1);
  for (int i = 0; i <= elements; ++i) {
    const double share = static_cast<double>(i) / elements;
    nodes.col(i) = (1.0 - share) * base + share * tip;
  }
  // A round section has no axes of its own: the coordinate axis that is furthest from the needle's.
  int second = 0;
  (tip - base).cwiseAbs().minCoeff(&second);
  return chain_of_beams(round_section(properties), nodes, Vector3d::Unit(second));
}

NeedleState needle_at_rest(const Needle& needle) {
  NeedleState state;
  state.positions = needle.rest_positions;
  state.rotations.assign(needle.node_count(), Matrix3d::Identity());
  state.velocities = state.spins = Eigen::Matrix3Xd::Zero(3, needle.node_count());
  return state;
}

Eigen::VectorXd generalized_velocity(const NeedleState& state) {
  Eigen::VectorXd velocity(6 * state.positions.cols());
  for (Eigen::Index i = 0; i < state.positions.cols(); ++i)
    velocity.segment<6>(6 * i) << state.velocities.col(i), state.spins.col(i);
  return velocity;
}

void set_generalized_velocity(const Eigen::VectorXd& velocity, NeedleState& state) {
  assert(velocity.size() == 6 * state.positions.cols());
  for (Eigen::Index i = 0; i < state.positions.cols(); ++i) {
    state.velocities.col(i) = velocity.segment<3>(6 * i);
    state.spins.col(i) = velocity.segment<3>(6 * i + 3);
  }
}

void advance(double tau, NeedleState& state) {
  for (Eigen::Index i = 0; i < state.positions.cols(); ++i) {
    state.positions.col(i) += tau * state.velocities.col(i);
    state.rotations[i] = orthonormalized(rotation_of(tau * state.spins.col(i)) * state.rotations[i]);
  }
}

void displace(const Eigen::VectorXd& increment, NeedleState& state) {
  assert(increment.size() == 6 * state.positions.cols());
  for (Eigen::Index i = 0; i < state.positions.cols(); ++i) {
    state.positions.col(i) += increment.segment<3>(6 * i);
    state.rotations[i] = orthonormalized(rotation_of(increment.segment<3>(6 * i + 3)) * state.rotations[i]);
  }
}

BeamElement beam_element(const Needle& needle, int e) {
  return {needle.sections[e], needle.rest_positions.col(e + 1) - needle.rest_positions.col(e), needle.rest_frames[e]};
}

BeamNodes beam_nodes(const NeedleState& state, int e) {
  return {state.positions.col(e + 1) - state.positions.col(e), {&state.rotations[e], &state.rotations[e + 1]}};
}

Eigen::VectorXd needle_forces(const Needle& needle, const NeedleState& state) {
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(needle.dof_count());
  for (int e = 0; e < needle.element_count(); ++e)
    forces.segment<12>(6 * e) += beam_forces(beam_element(needle, e), beam_nodes(state, e));
  return forces;
}

double needle_energy(const Needle& needle, const NeedleState& state) {
  double energy = 0.0;
  for (int e = 0; e < needle.element_count(); ++e) energy += beam_energy(beam_element(needle, e), beam_nodes(state, e));
  return energy;
}

Eigen::VectorXd needle_mass(const Needle& needle) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(needle.dof_count());
  for (int e = 0; e < needle.element_count(); ++e) {
    const double half = 0.5 * (needle.rest_positions.col(e + 1) - needle.rest_positions.col(e)).norm();
    for (int node = e; node <= e + 1; ++node) {
      mass.segment<3>(6 * node).array() += half * needle.sections[e].mass;
      mass.segment<3>(6 * node + 3).array() += half * needle.sections[e].polar_inertia;
    }
  }
  return mass;
}

double needle_kinetic_energy(const Needle& needle, const NeedleState& state) {
  const Eigen::VectorXd v = generalized_velocity(state);
  return 0.5 * v.dot(needle_mass(needle).cwiseProduct(v));
}

void add_material_stiffness(const Needle& needle, const NeedleState& state, double factor, ChainMatrix& A) {
  assert(A.node_count() == needle.node_count());
  for (int e = 0; e < needle.element_count(); ++e)
    add_element(factor * beam_material_stiffness(beam_element(needle, e), beam_nodes(state, e)), e, A);
}

void add_tangent_stiffness(const Needle& needle, const NeedleState& state, double factor, ChainMatrix& A) {
  assert(A.node_count() == needle.node_count());
  for (int e = 0; e < needle.element_count(); ++e) {
    const Matrix12 K = beam_tangent_stiffness(beam_element(needle, e), beam_nodes(state, e));
    add_element(0.5 * factor * (K + K.transpose()), e, A);
  }
}

}  // namespace finegauge
