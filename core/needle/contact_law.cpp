#include "core/needle/contact_law.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace finegauge {

namespace {

struct Bounds {
  double low, high;
};
/// Of friction along the needle, from the present lateral impulse.
Bounds friction_bounds(const ContactRows& point, double tau, const Eigen::Vector3d& lambda) {
  const double N = lambda.tail<2>().norm() + point.clamp * tau;
  return {-point.friction_out * N, point.friction_in * N};
}
double coulomb_bound(const ContactRows& point, const Eigen::Vector3d& lambda) {
  return point.surface_friction * std::max(lambda[0], 0.0);
}

/// Share of the way from a value to another at which it leaves the bounds; 1: not on the way.
double share_within(const Bounds& bounds, double from, double to) {
  if (to > bounds.high) return from < bounds.high ? (bounds.high - from) / (to - from) : 0.0;
  if (to < bounds.low) return from > bounds.low ? (bounds.low - from) / (to - from) : 0.0;
  return 1.0;
}
/// Of the whole way the trial itself, to the last bit.
double go(double from, double to, double step) { return step < 1.0 ? from + step * (to - from) : to; }

constexpr Bounds pushing{0.0, std::numeric_limits<double>::infinity()};

SetChange update_unilateral(const ContactRows& point, double tau, const ContactTrial& trial, bool may_change,
                            ContactState& state) {
  const bool coulomb = point.lateral == LateralLaw::coulomb;
  bool due, allowed;
  if (state.axial_holds) {
    due = trial.lambda[0] <= 0.0 && (coulomb || share_within(pushing, state.lambda[0], trial.lambda[0]) <= trial.step);
    allowed = !coulomb || may_change;
    state.lambda[0] = go(state.lambda[0], trial.lambda[0], trial.step);
  } else {
    due = trial.velocity[0] + point.gap[0] / tau > trial.tolerance;
    allowed = trial.step == 1.0 && (!coulomb || may_change);
  }
  if (!due) return SetChange::none;
  if (!allowed) return SetChange::refused;
  state.axial_holds = !state.axial_holds;
  state.lambda[0] = 0.0;
  return SetChange::made;
}

SetChange update_friction(const ContactRows& point, double tau, const ContactTrial& trial, ContactState& state) {
  const Bounds bounds = friction_bounds(point, tau, state.lambda);
  const double r = trial.velocity[0];
  if (bounds.high == 0.0 && bounds.low == 0.0) {  // no friction: nothing holds, and the slip only has a sign
    const bool held = state.axial_holds;
    state.axial_holds = false;
    state.axial_slip = r > 0.0 ? 1 : r < 0.0 ? -1 : 0;
    state.lambda[0] = 0.0;
    return held ? SetChange::made : SetChange::none;
  }
  if (state.axial_holds) {
    const int side = trial.lambda[0] > bounds.high ? 1 : trial.lambda[0] < bounds.low ? -1 : 0;
    const bool leaves = side != 0 && share_within(bounds, state.lambda[0], trial.lambda[0]) <= trial.step;
    state.lambda[0] = go(state.lambda[0], trial.lambda[0], trial.step);
    if (!leaves) return SetChange::none;
    state.axial_holds = false;
    state.axial_slip = side;
    state.lambda[0] = side > 0 ? bounds.high : bounds.low;
    return SetChange::made;
  }
  const bool due = state.axial_slip == 0 || state.axial_slip * r < -trial.tolerance;
  if (state.axial_slip != 0) state.lambda[0] = state.axial_slip > 0 ? bounds.high : bounds.low;
  if (!due) return SetChange::none;
  if (trial.step < 1.0) return SetChange::refused;
  state.axial_holds = true;
  state.axial_slip = 0;
  return SetChange::made;
}

SetChange update_coulomb(const ContactRows& point, const ContactTrial& trial, bool may_change, ContactState& state) {
  const double bound = coulomb_bound(point, state.lambda);
  const Eigen::Vector2d r = trial.velocity.tail<2>();
  if (bound == 0.0) {
    const bool held = state.lateral_holds;
    if (held && !may_change) return SetChange::refused;
    state.lateral_holds = false;
    state.lateral_slip = state.lambda[0] > 0.0 && r.squaredNorm() > 0.0;
    state.slip_direction.setZero();
    state.lambda.tail<2>().setZero();
    return held ? SetChange::made : SetChange::none;
  }
  if (state.lateral_holds) {
    const Eigen::Vector2d p{go(state.lambda[1], trial.lambda[1], trial.step),
                            go(state.lambda[2], trial.lambda[2], trial.step)};
    state.lambda.tail<2>() = p;
    if (p.squaredNorm() <= bound * bound) return SetChange::none;
    if (!may_change) return SetChange::refused;
    state.lateral_holds = false;
    state.lateral_slip = true;
    state.slip_direction = p / p.norm();
    state.lambda.tail<2>() = bound * state.slip_direction;
    return SetChange::made;
  }
  const bool slid = !state.slip_direction.isZero(0.0);
  if (slid && state.slip_direction.dot(r) >= -trial.tolerance) {
    // λ and W r both point along the slip at the solution; W is what weights them before.
    const Eigen::Vector2d p = state.lambda.tail<2>() + trial.lateral_weight * r;
    if (p.squaredNorm() > 0.0) state.slip_direction = p / p.norm();
    state.lambda.tail<2>() = bound * state.slip_direction;
    return SetChange::none;
  }
  state.lambda.tail<2>() = bound * state.slip_direction;
  if (!may_change) return SetChange::refused;
  if (!slid && r.squaredNorm() > trial.tolerance * trial.tolerance) {
    // A bound where there was none: what slides goes on sliding. To hold it first can tear the contact open, and so on
    // in a cycle.
    state.lateral_slip = true;
    state.slip_direction = r / r.norm();
    state.lambda.tail<2>() = bound * state.slip_direction;
    return SetChange::made;
  }
  state.lateral_holds = true;
  state.lateral_slip = false;
  state.slip_direction.setZero();
  return SetChange::made;
}

SetChange worse(SetChange a, SetChange b) { return std::max(a, b); }

}  // namespace

ContactState start_contact(const ContactRows& point, double tau, double violation) {
  ContactState state;
  state.lambda = point.lambda;
  if (point.axial == AxialLaw::none) state.lambda[0] = 0.0;
  if (point.lateral == LateralLaw::none) state.lambda.tail<2>().setZero();
  if (point.axial == AxialLaw::unilateral) state.lambda[0] = std::max(state.lambda[0], 0.0);
  if (point.lateral == LateralLaw::coulomb) {
    const double bound = coulomb_bound(point, state.lambda);
    state.lateral_holds = bound > 0.0;
    if (state.lambda.tail<2>().squaredNorm() > bound * bound)
      state.lambda.tail<2>() *= bound / state.lambda.tail<2>().norm();
  } else {
    state.lateral_holds = point.lateral == LateralLaw::bilateral;
  }
  state.axial_holds = point.axial == AxialLaw::bilateral ||
                      (point.axial == AxialLaw::unilateral && (state.lambda[0] > 0.0 || violation > 0.0));
  if (point.axial == AxialLaw::friction) {
    const Bounds bounds = friction_bounds(point, tau, state.lambda);
    state.axial_slip = state.lambda[0] == 0.0           ? 0
                       : state.lambda[0] >= bounds.high ? 1
                       : state.lambda[0] <= bounds.low  ? -1
                                                        : 0;
    state.axial_holds = state.axial_slip == 0 && (bounds.high > 0.0 || bounds.low < 0.0);
    state.lambda[0] = std::clamp(state.lambda[0], bounds.low, bounds.high);
  }
  return state;
}

double feasible_step(const ContactRows& point, double tau, const Eigen::Vector3d& trial, const ContactState& state) {
  if (!state.axial_holds || point.lateral == LateralLaw::coulomb) return 1.0;
  if (point.axial == AxialLaw::unilateral) return share_within(pushing, state.lambda[0], trial[0]);
  if (point.axial == AxialLaw::friction)
    return share_within(friction_bounds(point, tau, state.lambda), state.lambda[0], trial[0]);
  return 1.0;
}

SetChange update_contact(const ContactRows& point, double tau, const ContactTrial& trial, bool may_change,
                         ContactState& state) {
  SetChange change = SetChange::none;
  // Friction along the needle follows the lateral impulse, Coulomb's on the surface the axial one.
  if (point.lateral == LateralLaw::bilateral)
    for (const int i : {1, 2}) state.lambda[i] = go(state.lambda[i], trial.lambda[i], trial.step);
  if (point.axial == AxialLaw::bilateral) state.lambda[0] = go(state.lambda[0], trial.lambda[0], trial.step);
  if (point.axial == AxialLaw::unilateral) change = update_unilateral(point, tau, trial, may_change, state);
  if (point.lateral == LateralLaw::coulomb) change = worse(change, update_coulomb(point, trial, may_change, state));
  if (point.axial == AxialLaw::friction) change = worse(change, update_friction(point, tau, trial, state));
  return change;
}

double contact_violation(const ContactRows& point, double tau, const Eigen::Vector3d& velocity,
                         const ContactState& state) {
  const Eigen::Vector3d closing = velocity + point.gap / tau;
  double worst = 0.0;
  if (point.axial == AxialLaw::bilateral || (point.axial == AxialLaw::unilateral && state.axial_holds))
    worst = std::abs(closing[0]);
  else if (point.axial == AxialLaw::unilateral)
    worst = std::max(closing[0], 0.0);
  else if (point.axial == AxialLaw::friction)
    worst = state.axial_holds        ? std::abs(velocity[0])
            : state.lambda[0] == 0.0 ? 0.0
                                     : std::max(-state.axial_slip * velocity[0], 0.0);
  if (point.lateral == LateralLaw::bilateral) worst = std::max(worst, closing.tail<2>().cwiseAbs().maxCoeff());
  if (point.lateral == LateralLaw::coulomb)
    worst = std::max(worst, state.lateral_holds ? velocity.tail<2>().cwiseAbs().maxCoeff()
                                                : -state.slip_direction.dot(velocity.tail<2>()));
  return worst;
}

void clip_to_cone(const ContactRows& point, double tau, ContactState& state) {
  if (point.axial == AxialLaw::unilateral) state.lambda[0] = std::max(state.lambda[0], 0.0);
  if (point.lateral == LateralLaw::coulomb) {
    const double bound = coulomb_bound(point, state.lambda), size = state.lambda.tail<2>().norm();
    if (size > bound) state.lambda.tail<2>() *= bound / size;
  }
  if (point.axial == AxialLaw::friction) {
    const Bounds bounds = friction_bounds(point, tau, state.lambda);
    state.lambda[0] = std::clamp(state.lambda[0], bounds.low, bounds.high);
  }
}

}  // namespace finegauge
