#include "verification/studies/beam_benchmarks.hpp"

#include <gsl/gsl_sf_ellint.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/needle/rotation_vector.hpp"

namespace finegauge {

namespace {

using Eigen::Vector3d;
constexpr double infinite = std::numeric_limits<double>::infinity();

/// Nodes along x from the origin.
Eigen::Matrix3Xd straight_nodes(double length, int elements) {
  Eigen::Matrix3Xd nodes = Eigen::Matrix3Xd::Zero(3, elements + 1);
  for (int i = 0; i <= elements; ++i) nodes(0, i) = length * i / elements;
  return nodes;
}

HeldDofs clamped_base(const Needle& needle) {
  HeldDofs held(needle.node_count(), 0u);
  held[0] = hold_all;
  return held;
}

NeedleLoad at_tip(const Needle& needle, int entry, double value) {
  NeedleLoad load;
  load.reference = Eigen::VectorXd::Zero(needle.dof_count());
  load.reference[needle.dof_count() - 6 + entry] = value;
  return load;
}

NeedleEquilibrium solved(const Needle& needle, const HeldDofs& held, const NeedleLoad& load, const NeedleState& start,
                         int steps) {
  NeedleEquilibriumOptions options;
  options.steps = steps;
  NeedleEquilibrium result = solve_needle_equilibrium(needle, held, load, start, options);
  if (!result.converged)
    throw std::runtime_error("a beam benchmark did not converge: load factor " + std::to_string(result.load_factor) +
                             ", residual " + std::to_string(result.relative_residual));
  return result;
}

/// EI = 1 in both planes, no shear, hardly extensible; lengths are over L = 1.
BeamSection slender_section() {
  BeamSection section;
  section.EA = 1e8;
  section.GA_2 = section.GA_3 = infinite;
  section.GJ = section.EI_2 = section.EI_3 = 1.0;
  return section;
}

/// Displacement along z, rotations about x and y.
constexpr unsigned out_of_plane = 4u + 8u + 16u;

/// Angle of the tip section about z, in (-π, π].
double tip_angle(const NeedleState& state) {
  const Eigen::Matrix3d& R = state.rotations.back();
  return std::atan2(R(1, 0), R(0, 0));
}

}  // namespace

TimoshenkoRow timoshenko_cantilever(double slenderness, int elements) {
  NeedleProperties properties;
  const double L = properties.radius * slenderness;
  const Needle needle = chain_of_beams(round_section(properties), straight_nodes(L, elements), Vector3d::UnitY());
  const BeamSection& s = needle.sections.front();
  const double per_load = L * L * L / (3.0 * s.EI_3) + L / s.GA_2;
  const double P = small_deflection * L / per_load, exact = small_deflection * L;
  const HeldDofs held = clamped_base(needle);
  const NeedleLoad load = at_tip(needle, 1, P);
  const Eigen::Index tip = needle.dof_count() - 5;

  ChainMatrix K;
  K.set_zero(needle.node_count());
  add_tangent_stiffness(needle, needle_at_rest(needle), 1.0, K);
  hold(held, K);
  const ChainFactor factor(K);
  if (!factor.factored() || factor.negative_pivots() != 0)
    throw std::runtime_error("a clamped beam at rest has no positive tangent");
  Eigen::VectorXd x = load.reference;
  factor.solve(x);
  const NeedleEquilibrium result = solved(needle, held, load, needle_at_rest(needle), 1);
  return {slenderness, elements, std::abs(x[tip] / exact - 1.0),
          std::abs(result.state.positions(1, needle.node_count() - 1) / exact - 1.0)};
}

RollUpRow roll_up(double t, int elements, int steps, bool planar) {
  const Needle needle = chain_of_beams(slender_section(), straight_nodes(1.0, elements), Vector3d::UnitY());
  HeldDofs held(needle.node_count(), planar ? out_of_plane : 0u);
  held[0] = hold_all;
  const NeedleEquilibrium result = solved(needle, held, at_tip(needle, 5, t), needle_at_rest(needle), steps);
  const Vector3d exact(std::sin(t) / t, (1.0 - std::cos(t)) / t, 0.0);
  const double angle = std::remainder(tip_angle(result.state) - t, 2.0 * std::numbers::pi);
  return {t, elements, (result.state.positions.rightCols<1>() - exact).norm(), std::abs(angle), result.iterations};
}

ElasticaTip exact_elastica(double load) {
  if (!(load > 0.0 && std::isfinite(load))) throw std::invalid_argument("the elastica's load must be positive");
  // With tip angle φ: k² = (1 + sin φ) / 2, sin ψ = 1 / (k √2), √load = K(k) - F(ψ, k), which grows with φ.
  const double alpha = std::sqrt(load);
  const auto modulus = [](double phi) { return std::sqrt(0.5 * (1.0 + std::sin(phi))); };
  const auto amplitude = [](double k) { return std::asin(std::min(1.0, 1.0 / (k * std::numbers::sqrt2))); };
  double low = 0.0, high = 0.5 * std::numbers::pi;
  for (int step = 0; step < 200; ++step) {
    const double phi = 0.5 * (low + high), k = modulus(phi);
    const bool too_far =
        k >= 1.0 || gsl_sf_ellint_Kcomp(k, GSL_PREC_DOUBLE) - gsl_sf_ellint_F(amplitude(k), k, GSL_PREC_DOUBLE) > alpha;
    (too_far ? high : low) = phi;
  }
  const double phi = 0.5 * (low + high), k = modulus(phi);
  const double bent = gsl_sf_ellint_Ecomp(k, GSL_PREC_DOUBLE) - gsl_sf_ellint_E(amplitude(k), k, GSL_PREC_DOUBLE);
  return {1.0 - 2.0 * bent / alpha, 1.0 - std::sqrt(2.0 * std::sin(phi)) / alpha, phi};
}

ElasticaTip beam_elastica(double load, int elements, int steps) {
  const Needle needle = chain_of_beams(slender_section(), straight_nodes(1.0, elements), Vector3d::UnitY());
  const NeedleEquilibrium result =
      solved(needle, clamped_base(needle), at_tip(needle, 1, load), needle_at_rest(needle), steps);
  const Vector3d tip = result.state.positions.rightCols<1>();
  return {tip.y(), 1.0 - tip.x(), tip_angle(result.state)};
}

std::vector<ErrorSeries> elastica_convergence(double load, const std::vector<int>& elements, int steps) {
  std::vector<ErrorSeries> series(3);
  series[0].quantity = "deflection";
  series[1].quantity = "shortening";
  series[2].quantity = "angle";
  const ElasticaTip exact = exact_elastica(load);
  for (const int n : elements) {
    const ElasticaTip tip = beam_elastica(load, n, steps);
    for (ErrorSeries& s : series) s.h.push_back(1.0 / n);
    series[0].error.push_back(std::abs(tip.w - exact.w));
    series[1].error.push_back(std::abs(tip.u - exact.u));
    series[2].error.push_back(std::abs(tip.angle - exact.angle));
  }
  return series;
}

BendTip bend_45(const BendOptions& options) {
  constexpr double R = 100.0, E = 1e7, G = 0.5 * E;
  BeamSection section;
  section.EA = E;
  section.GA_2 = section.GA_3 = 5.0 / 6.0 * G;
  section.GJ = G * options.torsion_constant;
  section.EI_2 = section.EI_3 = E / 12.0;
  const int m = options.elements_per_chord, elements = options.chords * m;
  const auto on_arc = [&](int corner) {
    const double angle = 0.25 * std::numbers::pi * corner / options.chords;
    return Vector3d(R * (1.0 - std::cos(angle)), R * std::sin(angle), 0.0);
  };
  Eigen::Matrix3Xd nodes(3, elements + 1);
  for (int i = 0; i <= elements; ++i) {
    const double share = static_cast<double>(i % m) / m;
    nodes.col(i) = (1.0 - share) * on_arc(i / m) + share * on_arc(i / m + 1);
  }
  const Needle needle = chain_of_beams(section, nodes, Vector3d::UnitZ());
  const NeedleEquilibrium result =
      solved(needle, clamped_base(needle), at_tip(needle, 2, options.load), needle_at_rest(needle), options.steps);
  return {result.state.positions.rightCols<1>(), result.iterations};
}

LeeLimit lee_frame(bool shear, int elements_per_leg) {
  constexpr double leg = 120.0, A = 6.0, I = 2.0, E = 720.0, nu = 0.3;
  if (elements_per_leg % 5 != 0) throw std::invalid_argument("the load at a fifth of a leg must be at a node");
  BeamSection section;
  section.EA = E * A;
  section.GA_2 = section.GA_3 = shear ? 5.0 / 6.0 * E / (2.0 * (1.0 + nu)) * A : infinite;
  section.GJ = section.EI_2 = section.EI_3 = E * I;
  const int n = elements_per_leg;
  Eigen::Matrix3Xd nodes = Eigen::Matrix3Xd::Zero(3, 2 * n + 1);
  for (int i = 0; i <= n; ++i) {
    nodes.col(i) << 0.0, leg * i / n, 0.0;      // the column
    nodes.col(n + i) << leg * i / n, leg, 0.0;  // the beam
  }
  const Needle frame = chain_of_beams(section, nodes, Vector3d::UnitZ());
  HeldDofs held(frame.node_count(), out_of_plane);
  held.front() |= hold_position;
  held.back() |= hold_position;
  const int loaded = n + n / 5;
  NeedleLoad load;
  load.reference = Eigen::VectorXd::Zero(frame.dof_count());
  load.reference[6 * loaded + 1] = -1.0;
  ArcLengthOptions options;
  options.length = 0.02;  // the parabola below then leaves less than 1e-3 of the displacements
  options.points = 2000;
  const EquilibriumPath path =
      follow_equilibrium_path(frame, held, load, needle_at_rest(frame), options, [](const PathPoint& point) {
        return point.negative_pivots > 0 && point.load_factor < 1.7;  // well past the first maximum
      });
  const std::vector<PathPoint>& points = path.points;
  std::size_t top = 0;
  while (top + 1 < points.size() && points[top + 1].load_factor > points[top].load_factor) ++top;
  if (path.stalled || top < 2 || top + 2 >= points.size())
    throw std::runtime_error("the path of Lee's frame does not pass a maximum");

  // The parabola of the load over the path's parameter, the vertical displacement, through the maximum's neighbours.
  const auto displacement = [&](std::size_t k, int axis) {
    return points[k].state.positions(axis, loaded) - nodes(axis, loaded);
  };
  const auto newton_form = [](const double(&x)[3], const double(&y)[3]) {
    const double first = (y[1] - y[0]) / (x[1] - x[0]), next = (y[2] - y[1]) / (x[2] - x[1]);
    return Vector3d(y[0], first, (next - first) / (x[2] - x[0]));  // y = p0 + p1 (x - x0) + p2 (x - x0) (x - x1)
  };
  double v[3], u[3], P[3];
  for (int k = 0; k < 3; ++k) {
    v[k] = -displacement(top - 1 + k, 1);
    u[k] = displacement(top - 1 + k, 0);
    P[k] = points[top - 1 + k].load_factor;
  }
  const Vector3d p = newton_form(v, P), q = newton_form(v, u);
  LeeLimit limit;
  limit.vertical = 0.5 * (v[0] + v[1]) - 0.5 * p[1] / p[2];
  const double d_0 = limit.vertical - v[0], d_1 = limit.vertical - v[1];
  limit.load = p[0] + p[1] * d_0 + p[2] * d_0 * d_1;
  limit.horizontal = q[0] + q[1] * d_0 + q[2] * d_0 * d_1;
  limit.points = static_cast<int>(points.size());
  limit.pivots_before = points[top - 1].negative_pivots;
  limit.pivots_after = points[top + 1].negative_pivots;
  return limit;
}

std::vector<TurningRow> turning_base(const TurningBase& options) {
  // EI = 1 and 2 across, GJ = 0.9; the load bends by a third of the length. Across: about z, in the plane of the load.
  BeamSection section = slender_section();
  section.EA = 1e4;
  section.GJ = 0.9;
  section.EI_2 = 2.0;
  const Needle needle = chain_of_beams(section, straight_nodes(1.0, options.elements), Vector3d::UnitY());
  const HeldDofs held = clamped_base(needle);
  const NeedleLoad load = at_tip(needle, 1, options.about_own_axis ? 1.2 : 0.6);
  const double step = 2.0 * std::numbers::pi / options.steps_per_turn;
  const Eigen::Matrix3d turn = rotation_of(step * (options.about_own_axis ? Vector3d::UnitX() : Vector3d::UnitZ()));
  NeedleState state = needle_at_rest(needle);
  std::vector<TurningRow> rows;
  for (int k = 0; k <= options.turns * options.steps_per_turn; ++k) {
    if (k > 0) {
      // The needle follows its base as a rigid body; the load turns it back into balance.
      state.positions = turn * state.positions;
      for (Eigen::Matrix3d& R : state.rotations) R = turn * R;
    }
    state = solved(needle, held, load, state, 1).state;
    const Eigen::VectorXd forces = needle_forces(needle, state);
    rows.push_back(
        {k * step, needle_energy(needle, state), forces.segment<3>(3).norm(), state.positions.rightCols<1>()});
  }
  return rows;
}

}  // namespace finegauge
