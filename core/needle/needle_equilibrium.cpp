#include "core/needle/needle_equilibrium.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace finegauge {

namespace {

using Eigen::VectorXd;

double whole_length(const Needle& needle) {
  double length = 0.0;
  for (int e = 0; e < needle.element_count(); ++e) length += beam_element(needle, e).rest_chord.norm();
  return length;
}

/// ‖f‖² with moments over a length.
double squared_size(const VectorXd& f, double length) {
  double forces = 0.0, moments = 0.0;
  for (Eigen::Index i = 0; i < f.size(); i += 6) {
    forces += f.segment<3>(i).squaredNorm();
    moments += f.segment<3>(i + 3).squaredNorm();
  }
  return forces + moments / (length * length);
}

/// Translations of a generalized vector: Σ a_i · b_i.
double dot_translations(const VectorXd& a, const VectorXd& b) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < a.size(); i += 6) sum += a.segment<3>(i).dot(b.segment<3>(i));
  return sum;
}

/// Square of the forces that the rounding of positions and rotations alone makes.
double squared_round_off(const Needle& needle, const NeedleState& state) {
  const double largest = state.positions.cwiseAbs().maxCoeff();
  double sum = 0.0;
  for (int e = 0; e < needle.element_count(); ++e) {
    const double l = beam_element(needle, e).rest_chord.norm();
    const LocalStiffness D = local_stiffness(needle.sections[e], l);
    const double stiffness = D.axial + D.same_end.sum() / (l * l);
    const double force = stiffness * (largest + l);
    sum += force * force;
  }
  constexpr double unit = 4.0 * std::numeric_limits<double>::epsilon();
  return unit * unit * sum;
}

VectorXd or_zero(const VectorXd& load, const Needle& needle) {
  if (load.size() == 0) return VectorXd::Zero(needle.dof_count());
  assert(load.size() == needle.dof_count());
  return load;
}

/// Out-of-balance forces under one load and how large they are.
struct Balance {
  VectorXd residual;      ///< free f_ext - f_int
  double relative = 0.0;  ///< see NeedleEquilibriumOptions
  bool finite = false, at_round_off = false;

  /// Forces at the level of round-off are balanced only when Newton's method no longer lowers them: the level says what
  /// rounding may do, not what it did.
  bool reached(double tolerance, double previous) const {
    return finite && (relative <= tolerance || (at_round_off && relative > 0.5 * previous));
  }
};
Balance balance(const Needle& needle, const HeldDofs& held, const VectorXd& load, const NeedleState& state) {
  const double length = whole_length(needle);
  const VectorXd internal = needle_forces(needle, state);
  Balance b;
  b.residual = load - internal;
  hold(held, b.residual);
  const double size = std::max(squared_size(load, length), squared_size(internal, length));
  const double square = squared_size(b.residual, length);
  b.finite = std::isfinite(square) && std::isfinite(size);
  if (!b.finite) {
    b.relative = std::numeric_limits<double>::infinity();
    return b;
  }
  b.relative = square > 0.0 ? std::sqrt(square / size) : 0.0;
  b.at_round_off = square <= squared_round_off(needle, state);
  return b;
}

/// The tangent with its supports.
void assemble_held_tangent(const Needle& needle, const HeldDofs& held, const NeedleState& state, ChainMatrix& K) {
  K.set_zero(needle.node_count());
  add_tangent_stiffness(needle, state, 1.0, K);
  hold(held, K);
}

VectorXd translations(const NeedleState& from, const NeedleState& to) {
  VectorXd step = VectorXd::Zero(6 * from.positions.cols());
  for (Eigen::Index i = 0; i < from.positions.cols(); ++i)
    step.segment<3>(6 * i) = to.positions.col(i) - from.positions.col(i);
  return step;
}

void stop_moving(NeedleState& state) {
  state.velocities.setZero();
  state.spins.setZero();
}

}  // namespace

NeedleEquilibrium solve_needle_equilibrium(const Needle& needle, const HeldDofs& held, const NeedleLoad& load,
                                           const NeedleState& start, const NeedleEquilibriumOptions& options) {
  const VectorXd fixed = or_zero(load.fixed, needle), reference = or_zero(load.reference, needle);
  assert(options.steps >= 1);
  NeedleEquilibrium result;
  result.state = start;
  stop_moving(result.state);
  ChainMatrix K;
  ChainFactor factor;
  NeedleState state = result.state;
  for (int step = 1; step <= options.steps; ++step) {
    const double load_factor = step == options.steps ? 1.0 : static_cast<double>(step) / options.steps;
    const VectorXd external = fixed + load_factor * reference;
    Balance out = balance(needle, held, external, state);
    double previous = std::numeric_limits<double>::infinity();
    for (int iteration = 0; !out.reached(options.residual, previous); ++iteration) {
      result.relative_residual = previous = out.relative;
      if (!out.finite || iteration == options.iterations) return result;
      assemble_held_tangent(needle, held, state, K);
      factor.factor(K);
      if (!factor.factored()) return result;
      factor.solve(out.residual);
      displace(out.residual, state);
      ++result.iterations;
      out = balance(needle, held, external, state);
    }
    result.relative_residual = out.relative;
    result.load_factor = load_factor;
    result.state = state;
  }
  assemble_held_tangent(needle, held, result.state, K);
  factor.factor(K);
  result.negative_pivots = factor.factored() ? factor.negative_pivots() : -1;
  result.converged = true;
  return result;
}

namespace {

/// One step of the path: from `state` along `direction`, the predictor for a load factor of one.
struct Step {
  bool converged = false;
  int iterations = 0;
  double load_factor = 0.0;
  NeedleState state;
};
Step arc_length_step(const Needle& needle, const HeldDofs& held, const VectorXd& fixed, const VectorXd& reference,
                     const PathPoint& from, const VectorXd& response, double change, double length,
                     const ArcLengthOptions& options) {
  Step step{false, 0, from.load_factor + change, from.state};
  displace(change * response, step.state);
  ChainMatrix K;
  ChainFactor factor;
  Eigen::MatrixXd solutions(needle.dof_count(), 2);
  VectorXd reference_free = reference;
  hold(held, reference_free);
  double previous = std::numeric_limits<double>::infinity();
  for (; step.iterations < options.iterations; ++step.iterations) {
    const Balance out = balance(needle, held, fixed + step.load_factor * reference, step.state);
    if (!out.finite) return step;
    if (out.reached(options.residual, previous) && step.iterations > 0) {
      step.converged = true;
      return step;
    }
    previous = out.relative;
    assemble_held_tangent(needle, held, step.state, K);
    factor.factor(K);
    if (!factor.factored()) return step;
    solutions << out.residual, reference_free;
    factor.solve(solutions);
    // ‖Δx + δx_r + δλ x_t‖ = length; of the two roots the one that turns back less.
    const VectorXd so_far = translations(from.state, step.state);
    const VectorXd moved = so_far + solutions.col(0), tangent = solutions.col(1);
    const double a = dot_translations(tangent, tangent), half_b = dot_translations(tangent, moved);
    const double c = dot_translations(moved, moved) - length * length;
    const double discriminant = half_b * half_b - a * c;
    if (!(discriminant >= 0.0 && a > 0.0)) return step;
    const double forward = dot_translations(so_far, tangent) >= 0.0 ? 1.0 : -1.0;
    const double d_lambda = (-half_b + forward * std::sqrt(discriminant)) / a;
    displace(solutions.col(0) + d_lambda * tangent, step.state);
    step.load_factor += d_lambda;
  }
  return step;
}

}  // namespace

EquilibriumPath follow_equilibrium_path(const Needle& needle, const HeldDofs& held, const NeedleLoad& load,
                                        const NeedleState& start, const ArcLengthOptions& options,
                                        const std::function<bool(const PathPoint&)>& enough) {
  const VectorXd fixed = or_zero(load.fixed, needle), reference = or_zero(load.reference, needle);
  EquilibriumPath path;
  path.points.push_back({0.0, start, 0});
  stop_moving(path.points.back().state);
  ChainMatrix K;
  ChainFactor factor;
  VectorXd last;  // translations of the step before
  double full_length = 0.0, length = 0.0;
  while (true) {
    PathPoint& from = path.points.back();
    assemble_held_tangent(needle, held, from.state, K);
    factor.factor(K);
    from.negative_pivots = factor.factored() ? factor.negative_pivots() : -1;
    if (enough(from) || static_cast<int>(path.points.size()) >= options.points) return path;
    path.stalled = true;
    if (!factor.factored()) return path;
    VectorXd response = reference;
    hold(held, response);
    factor.solve(response);
    const double speed = std::sqrt(dot_translations(response, response));
    if (!(speed > 0.0)) return path;
    if (path.points.size() == 1) full_length = length = options.length * speed;
    const double sign = last.size() > 0 && dot_translations(response, last) < 0.0 ? -1.0 : 1.0;
    Step step;
    for (int halvings = 0; !step.converged && halvings <= 20; ++halvings) {
      if (halvings > 0) length *= 0.5;
      step = arc_length_step(needle, held, fixed, reference, from, response, sign * length / speed, length, options);
    }
    if (!step.converged) return path;
    path.stalled = false;
    last = translations(from.state, step.state);
    path.points.push_back({step.load_factor, std::move(step.state), 0});
    if (step.iterations <= 6) length = std::min(2.0 * length, full_length);
  }
}

}  // namespace finegauge
