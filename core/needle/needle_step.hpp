#pragma once

#include <Eigen/Core>

#include "core/needle/needle.hpp"
#include "core/needle/needle_drive.hpp"

namespace finegauge {

/// The linear system of a needle's step of backward Euler, A = M + τ² K, b = τ f - τ² K v with the material stiffness
/// K, in components along the base axis and two directions across it, so that the guide holds whole components.
struct NeedleSystem {
  Eigen::Matrix3d axes;       ///< columns: base axis, two across; global <- axis components
  ChainMatrix A, held_A;      ///< without and with holds
  Eigen::VectorXd b, held_b;  ///< held_b: zero where held, the prescribed part carried over
  HeldDofs held;
  Eigen::VectorXd velocity;    ///< v at the start, or the guess
  Eigen::VectorXd prescribed;  ///< dv of held dofs
  Eigen::VectorXd mass;        ///< [kg], [kg m²]
};
NeedleSystem start_needle_system(const Needle& needle);

/// The system of the step from `time` to `time` + τ. Node 0 follows the drive; with a guide the nodes more than an
/// element before `entry_length` (NeedleContacts::entry_length) keep their place across the axis relative to the base:
/// one that is held nearer to the tissue would be a lever on it. With a `guess` of the end velocity (axis components)
/// it is linearized there and dv corrects the guess. `system` is overwritten.
void assemble_needle_step(const Needle& needle, const NeedleDrive& drive, const NeedleState& state, double entry_length,
                          const Eigen::Vector3d& gravity, const Eigen::VectorXd* guess, double time, double tau,
                          NeedleSystem& system);

/// v <- end velocity (axis components), x <- x + τ v.
void advance_needle(const NeedleSystem& system, const Eigen::VectorXd& end_velocity, double tau, NeedleState& state);

/// Impulses of what holds the needle, zero elsewhere: A dv - b + Jᵀ λ in held dofs, with the whole dv [N s].
Eigen::VectorXd hold_reactions(const NeedleSystem& system, const Eigen::VectorXd& dv,
                               const Eigen::VectorXd& constraint_impulse);

/// What the step takes from the energy of a linear needle: ½ dvᵀ M dv + ½ τ² v⁺ᵀ K v⁺ [J].
double numerical_dissipation(const NeedleSystem& system, const Eigen::VectorXd& dv,
                             const Eigen::VectorXd& end_velocity);

}  // namespace finegauge
