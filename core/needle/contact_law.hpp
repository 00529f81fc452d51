#pragma once

#include <Eigen/Core>

#include "core/needle/contact_rows.hpp"

namespace finegauge {

/// Where a point's impulses stand within the iteration on them. A direction holds (its row is in J_a and λ is what
/// keeps it) or does not: then λ is fixed at its bound or zero.
struct ContactState {
  Eigen::Vector3d lambda = Eigen::Vector3d::Zero();  ///< [N s], in the frame
  bool axial_holds = false, lateral_holds = false;
  int axial_slip = 0;         ///< of friction: +1 at the bound against advance, -1 at that against withdrawal
  bool lateral_slip = false;  ///< of Coulomb's law, at a bound > 0
  Eigen::Vector2d slip_direction = Eigen::Vector2d::Zero();  ///< unit, of the impulse of a lateral slip
};

/// From the start value of λ, pulled into its cone: a friction row on its bound starts slipping, all else holds (of
/// unilateral rows: those with λ > 0, or that would be violated by `violation`, J_n v + g_n/τ [m/s]).
ContactState start_contact(const ContactRows& point, double tau, double violation);

/// What one iteration found at a point.
struct ContactTrial {
  Eigen::Vector3d lambda;    ///< λ + W (J dv - rhs) where a direction holds [N s]
  Eigen::Vector3d velocity;  ///< r after the step [m/s]
  double lateral_weight;     ///< weighs r against λ where a lateral slip turns, any > 0 [kg]
  double tolerance;          ///< velocities below are none [m/s]
  double step = 1.0;         ///< share of the way from λ to the trial that is gone: at most any feasible_step
};
/// The share of the way from λ to `trial` after which the impulse along the needle leaves its cone, at most 1. Of rows
/// that do not hold and of points under Coulomb's law 1.
double feasible_step(const ContactRows& point, double tau, const Eigen::Vector3d& trial, const ContactState& state);

enum class SetChange {
  none,
  made,
  refused  ///< due, but not allowed
};
/// λ <- projection of the trial onto the cone, with the bounds of the new λ: leaves J_a past its bound, returns when
/// the slip reverses or the gap closes, λ then starting from the bound and not from beyond (one iteration cannot
/// cross the cone). After a step < 1 only the rows leave whose bounds are met by then, and none returns, since the
/// velocity is the whole trial's. `may_change` is for points under Coulomb's law, which change after whole steps only:
/// where they may not, λ keeps its value, out of the cone or not.
SetChange update_contact(const ContactRows& point, double tau, const ContactTrial& trial, bool may_change,
                         ContactState& state);

/// The largest velocity [m/s] by which a point breaks its law: of rows that hold |r + g/τ| (no gap for friction and
/// Coulomb's law), of an open unilateral row what penetrates, of a slip what moves against its impulse.
double contact_violation(const ContactRows& point, double tau, const Eigen::Vector3d& velocity,
                         const ContactState& state);

/// λ inside its cone whatever the state, for what is returned without convergence.
void clip_to_cone(const ContactRows& point, double tau, ContactState& state);

}  // namespace finegauge
