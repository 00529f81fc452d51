#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/needle/beam_element.hpp"
#include "core/needle/beam_section.hpp"
#include "core/needle/chain_matrix.hpp"

namespace finegauge {

/// A chain of beam elements: element e joins nodes e and e + 1. Node 0 is the base, the last node the tip.
struct Needle {
  std::vector<BeamSection> sections;         ///< per element
  Eigen::Matrix3Xd rest_positions;           ///< [m], 3 × nodes
  std::vector<Eigen::Matrix3d> rest_frames;  ///< per element: columns are its axes at rest, first along the chord

  int node_count() const { return static_cast<int>(rest_positions.cols()); }
  int element_count() const { return node_count() - 1; }
  int dof_count() const { return 6 * node_count(); }
};
/// A straight needle of equal elements from base to tip. Throws std::invalid_argument without an element or a length.
Needle straight_needle(const NeedleProperties& properties, const Eigen::Vector3d& base, const Eigen::Vector3d& tip,
                       int elements);
/// A chain along given nodes, one section throughout; `second_axis` is any vector that spans, with each chord, the
/// plane of axes 1 and 2. The elements are straight, so a curved axis has kinks at the nodes, where the chain is
/// stress-free. Throws std::invalid_argument where neighbours coincide or the second axis lies along a chord.
Needle chain_of_beams(const BeamSection& section, const Eigen::Matrix3Xd& nodes, const Eigen::Vector3d& second_axis);

/// Where the needle is. Rotations carry rest directions to current ones; spins are angular velocities in global axes.
struct NeedleState {
  Eigen::Matrix3Xd positions;              ///< [m], 3 × nodes
  std::vector<Eigen::Matrix3d> rotations;  ///< per node, identity at rest
  Eigen::Matrix3Xd velocities;             ///< [m/s]
  Eigen::Matrix3Xd spins;                  ///< [rad/s]
};
NeedleState needle_at_rest(const Needle& needle);

/// Generalized forces and velocities have six entries a node: force [N] or velocity, then moment [N m] or spin.
Eigen::VectorXd generalized_velocity(const NeedleState& state);
void set_generalized_velocity(const Eigen::VectorXd& velocity, NeedleState& state);
/// x <- x + τ v, R <- exp(τ ω) R, with the velocities in `state`; R stays orthonormal however often.
void advance(double tau, NeedleState& state);
/// x <- x + δx, R <- exp(δθ) R for an increment of six entries a node; velocities stay.
void displace(const Eigen::VectorXd& increment, NeedleState& state);

/// The element's part of needle and state. They must outlive it.
BeamElement beam_element(const Needle& needle, int element);
BeamNodes beam_nodes(const NeedleState& state, int element);

/// Internal forces [N, N m], those that hold the needle in its shape: the exact gradient of needle_energy, so that they
/// depend on the configuration alone (path independence), for rotations of any size.
Eigen::VectorXd needle_forces(const Needle& needle, const NeedleState& state);
/// Stored elastic energy [J].
double needle_energy(const Needle& needle, const NeedleState& state);
/// Lumped mass and rotary inertia, half of each element's to each end; six entries a node. Rotary ones are isotropic
/// with the section's polar inertia, its largest, so that no gyroscopic term arises; constant in time.
Eigen::VectorXd needle_mass(const Needle& needle);
double needle_kinetic_energy(const Needle& needle, const NeedleState& state);

/// Adds factor × the material stiffness Bᵀ D B at the state: positive semidefinite whatever the load, the counterpart
/// of the tissue's frozen rotations. Used by a step's one linear solve.
void add_material_stiffness(const Needle& needle, const NeedleState& state, double factor, ChainMatrix& A);
/// Adds factor × the symmetric part of the full tangent, geometric terms included (for increments of rotation
/// δR = [δθ]× R). The skew part is half of [m]× in each node's rotations, m the sum of the internal moments there: it
/// vanishes at equilibrium but for applied moments. For Newton's method.
void add_tangent_stiffness(const Needle& needle, const NeedleState& state, double factor, ChainMatrix& A);

}  // namespace finegauge
