#include "core/needle/centreline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/needle/rotation_vector.hpp"

namespace finegauge {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Cubic Hermite functions of ends and end derivatives.
struct Hermite {
  double end_1, end_2, slope_1, slope_2;
};
Hermite hermite(double s) {
  return {(1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s), s * s * (3.0 - 2.0 * s), s * (1.0 - s) * (1.0 - s),
          s * s * (s - 1.0)};
}
Hermite hermite_derivative(double s) {
  return {6.0 * s * (s - 1.0), 6.0 * s * (1.0 - s), (1.0 - s) * (1.0 - 3.0 * s), s * (3.0 * s - 2.0)};
}

/// Coefficients of the shear angle across e_2 and e_3: Φ / (2 (1 + Φ)), with Φ of bending about axes 3 and 2.
Eigen::Vector2d shear_shares(const BeamSection& section, double rest_length) {
  const Eigen::Vector2d Phi = shear_ratios(section, rest_length);
  return {0.5 * Phi[1] / (1.0 + Phi[1]), 0.5 * Phi[0] / (1.0 + Phi[0])};
}

/// An element's cubic.
struct Cubic {
  Vector3d x_1, chord;        ///< [m]
  Vector3d slope_1, slope_2;  ///< derivatives by the share at the ends [m]

  /// x_1 H_1 + x_2 H_2 = x_1 + chord H_2.
  Vector3d position(double s) const {
    const Hermite h = hermite(s);
    return x_1 + (chord * h.end_2 + slope_1 * h.slope_1 + slope_2 * h.slope_2);
  }
  Vector3d derivative(double s) const {
    const Hermite h = hermite_derivative(s);
    return chord * h.end_2 + slope_1 * h.slope_1 + slope_2 * h.slope_2;
  }
  Vector3d second_derivative(double s) const {
    return chord * (6.0 - 12.0 * s) + slope_1 * (6.0 * s - 4.0) + slope_2 * (6.0 * s - 2.0);
  }
};
Cubic cubic_of(const Needle& needle, const NeedleState& state, int e) {
  assert(e >= 0 && e < needle.element_count());
  const Matrix3d& frame = needle.rest_frames[e];
  const double rest_length = (needle.rest_positions.col(e + 1) - needle.rest_positions.col(e)).norm();
  const Vector3d d_1 = state.rotations[e] * frame.col(0), d_2 = state.rotations[e + 1] * frame.col(0);
  Cubic cubic;
  cubic.x_1 = state.positions.col(e);
  cubic.chord = state.positions.col(e + 1) - state.positions.col(e);
  const Eigen::Vector2d share = shear_shares(needle.sections[e], rest_length);
  const Vector3d mean = state.rotations[e] * frame.col(1) + state.rotations[e + 1] * frame.col(1);
  const Vector3d e_1 = cubic.chord.normalized(), e_3 = e_1.cross(mean).normalized(), e_2 = e_3.cross(e_1);
  const Vector3d both = d_1 + d_2;
  const Vector3d gamma = -share[0] * e_2.dot(both) * e_2 - share[1] * e_3.dot(both) * e_3;
  cubic.slope_1 = rest_length * (d_1 + gamma);
  cubic.slope_2 = rest_length * (d_2 + gamma);
  return cubic;
}

struct Candidate {
  double share = 0.0, squared_distance = std::numeric_limits<double>::infinity();
};

/// The closest share of one cubic.
Candidate closest_share(const Cubic& cubic, const Vector3d& x) {
  const auto at = [&](double s) { return Candidate{s, (cubic.position(s) - x).squaredNorm()}; };
  constexpr double spacing = 0.25;
  Candidate best;
  for (int k = 0; k <= 4; ++k) {
    const Candidate next = at(k * spacing);
    if (next.squared_distance < best.squared_distance) best = next;
  }
  // A root of (x(s) - x)·x'(s) between the neighbours, or the end where it does not change sign.
  double low = std::max(0.0, best.share - spacing), high = std::min(1.0, best.share + spacing);
  double s = best.share;
  for (int step = 0; step < 60 && low < high; ++step) {
    const Vector3d offset = cubic.position(s) - x, slope = cubic.derivative(s);
    const double g = offset.dot(slope);
    if (g == 0.0) break;
    (g > 0.0 ? high : low) = s;
    const double curvature = slope.squaredNorm() + offset.dot(cubic.second_derivative(s));
    double next = s - g / curvature;
    if (!(curvature > 0.0 && next >= low && next <= high)) next = 0.5 * (low + high);
    const double change = std::abs(next - s);
    s = next;
    if (change <= 0.5 * std::numeric_limits<double>::epsilon()) break;  // of a share: no unit
  }
  const Candidate refined = at(s);
  return refined.squared_distance <= best.squared_distance ? refined : best;
}

double squared_distance_from_chord(const Vector3d& a, const Vector3d& b, const Vector3d& x) {
  const Vector3d chord = b - a;
  const double square = chord.squaredNorm();
  const double share = square > 0.0 ? std::clamp((x - a).dot(chord) / square, 0.0, 1.0) : 0.0;
  return (a + share * chord - x).squaredNorm();
}

}  // namespace

Vector3d centreline_position(const Needle& needle, const NeedleState& state, CentrelinePoint point) {
  return cubic_of(needle, state, point.element).position(point.share);
}

Vector3d centreline_tangent(const Needle& needle, const NeedleState& state, CentrelinePoint point) {
  return cubic_of(needle, state, point.element).derivative(point.share).normalized();
}

double arc_length(const Needle& needle, CentrelinePoint point) {
  double length = 0.0;
  for (int e = 0; e < point.element; ++e) length += beam_element(needle, e).rest_chord.norm();
  return length + point.share * beam_element(needle, point.element).rest_chord.norm();
}

CentrelinePoint at_arc_length(const Needle& needle, double length) {
  assert(!std::isnan(length));
  double before = 0.0;
  for (int e = 0; e < needle.element_count(); ++e) {
    const double l = beam_element(needle, e).rest_chord.norm();
    if (length < before + l) return {e, std::max(0.0, (length - before) / l)};
    before += l;
  }
  return {needle.element_count() - 1, 1.0};
}

ClosestPoint closest_point(const Needle& needle, const NeedleState& state, const Vector3d& x) {
  const auto chord_distance = [&](int e) {
    return squared_distance_from_chord(state.positions.col(e), state.positions.col(e + 1), x);
  };
  int nearest = 0;
  double nearest_square = std::numeric_limits<double>::infinity();
  for (int e = 0; e < needle.element_count(); ++e) {
    const double square = chord_distance(e);
    if (square < nearest_square) nearest_square = square, nearest = e;
  }
  // The cubic departs from its chord by less than its rest length: x(s) - (x_1 + s chord) is a sum of the two slopes
  // less the chord with weights whose sizes add to s (1 - s), and each difference is at most l_0 (2 + 2) + l. So no
  // element further away than the best distance so far and that length can be closer.
  Candidate best = closest_share(cubic_of(needle, state, nearest), x);
  int element = nearest;
  for (int e = 0; e < needle.element_count(); ++e) {
    if (e == nearest) continue;
    const double reach = 0.25 * (3.0 * beam_element(needle, e).rest_chord.norm() + beam_nodes(state, e).chord.norm()) +
                         std::sqrt(best.squared_distance);
    if (chord_distance(e) > reach * reach) continue;
    const Candidate next = closest_share(cubic_of(needle, state, e), x);
    if (next.squared_distance < best.squared_distance ||
        (next.squared_distance == best.squared_distance && e < element))
      best = next, element = e;
  }
  ClosestPoint closest{{element, best.share}, std::sqrt(best.squared_distance), 0.0};
  if (element == needle.element_count() - 1 && best.share == 1.0) {
    const Vector3d offset = x - state.positions.rightCols<1>();
    closest.distance_past_tip = std::max(0.0, offset.dot(centreline_tangent(needle, state, closest.point)));
  }
  return closest;
}

Eigen::Matrix<double, 3, 12> centreline_velocity(const Needle& needle, const NeedleState& state,
                                                 CentrelinePoint point) {
  const int e = point.element;
  const Matrix3d& frame = needle.rest_frames[e];
  const BeamConfiguration c = configuration(beam_element(needle, e), beam_nodes(state, e));
  const Eigen::Vector2d share = shear_shares(needle.sections[e], c.rest_length);
  const Hermite h = hermite(point.share);
  const Vector3d d[2] = {state.rotations[e] * frame.col(0), state.rotations[e + 1] * frame.col(0)};
  const double slope[2] = {c.rest_length * h.slope_1, c.rest_length * h.slope_2};
  const double both_slopes = slope[0] + slope[1];

  Eigen::Matrix<double, 3, 12> N = Eigen::Matrix<double, 3, 12>::Zero();
  N.leftCols<3>() = h.end_1 * Matrix3d::Identity();
  N.middleCols<3>(6) = h.end_2 * Matrix3d::Identity();
  // γ = -C (d_1 + d_2) with C = R_e diag(0, shares) R_eᵀ, so that δγ = -C (δd_1 + δd_2) - [δθ_e]× C d + C [δθ_e]× d.
  const Matrix3d C = c.frame * Vector3d(0.0, share[0], share[1]).asDiagonal() * c.frame.transpose();
  for (int i = 0; i < 2; ++i)
    N.middleCols<3>(6 * i + 3) = -(slope[i] * Matrix3d::Identity() - both_slopes * C) * cross_matrix(d[i]);
  const Vector3d both = d[0] + d[1];
  const Matrix3d by_frame = both_slopes * (cross_matrix(C * both) - C * cross_matrix(both));
  Eigen::Matrix<double, 3, 12> spin = c.frame * frame_spin(c);
  for (int block = 0; block < 4; ++block)
    N.middleCols<3>(3 * block) += by_frame * spin.middleCols<3>(3 * block) * c.frame.transpose();
  return N;
}

}  // namespace finegauge
