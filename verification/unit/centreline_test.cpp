#include "core/needle/centreline.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/needle/rotation_vector.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/convergence.hpp"
#include "verification/support/needle_samples.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

BeamSection section_with_shear(double GA_2, double GA_3) {
  BeamSection section;
  section.EA = 40.0;
  section.GA_2 = GA_2;
  section.GA_3 = GA_3;
  section.GJ = 1.7;
  section.EI_2 = 3.0;
  section.EI_3 = 1.1;
  return section;
}
constexpr double infinite = std::numeric_limits<double>::infinity();

/// Straight along a skew line, or kinked.
Needle sample_needle(const BeamSection& section, bool straight) {
  Eigen::Matrix3Xd nodes(3, 5);
  nodes << 0.0, 1.0, 1.9, 2.7, 3.1, 0.0, 0.1, -0.1, 0.3, 1.2, 0.0, 0.0, 0.3, 0.5, 0.7;
  if (straight)
    for (int i = 0; i < 5; ++i) nodes.col(i) = (0.9 + 0.1 * i) * i * Eigen::Vector3d(0.9, 0.3, -0.2);
  return chain_of_beams(section, nodes, {0.1, 0.2, 1.0});
}

}  // namespace

TEST_CASE("the axis passes through the nodes, and its tangent there is the section's normal without shear",
          "[needle][centreline]") {
  std::mt19937 generator(31);
  const Needle needle = sample_needle(section_with_shear(infinite, infinite), true);
  const NeedleState state = sample_state(needle, 0.3, generator);
  for (int e = 0; e < needle.element_count(); ++e)
    for (int end = 0; end < 2; ++end) {
      const CentrelinePoint point{e, static_cast<double>(end)};
      CHECK((centreline_position(needle, state, point) - state.positions.col(e + end)).norm() < 1e-15 * 8.0);
      const Eigen::Vector3d normal = state.rotations[e + end] * needle.rest_frames[e].col(0);
      CHECK((centreline_tangent(needle, state, point) - normal).norm() < 1e-15 * 8.0);
    }
}

TEST_CASE("with shear the axis leaves the section's normal by the shear force over GA", "[needle][centreline]") {
  // A cantilever of one element under small tip loads along both axes: w(s) = P (3 L s² - s³) / 6 EI + P s / GA.
  const BeamSection section = section_with_shear(9.0, 14.0);
  Eigen::Matrix3Xd nodes = Eigen::Matrix3Xd::Zero(3, 2);
  const double L = 1.3, P = 1e-7, Q = -2e-7;
  nodes(0, 1) = L;
  const Needle needle = chain_of_beams(section, nodes, Eigen::Vector3d::UnitY());
  NeedleState state = needle_at_rest(needle);
  const double bend_3 = P * L * L / (2.0 * section.EI_3), bend_2 = Q * L * L / (2.0 * section.EI_2);
  state.positions(1, 1) = bend_3 * L * 2.0 / 3.0 + P * L / section.GA_2;
  state.positions(2, 1) = bend_2 * L * 2.0 / 3.0 + Q * L / section.GA_3;
  state.rotations[1] = rotation_of({0.0, -bend_2, bend_3});
  for (const double s : {0.0, 0.2, 0.5, 0.9, 1.0}) {
    CAPTURE(s);
    const double cubic = (3.0 * s * s - s * s * s) * L * L * L / 6.0;
    const Eigen::Vector3d x = centreline_position(needle, state, {0, s});
    const double y = P * (cubic / section.EI_3 + L * s / section.GA_2);
    const double z = Q * (cubic / section.EI_2 + L * s / section.GA_3);
    CHECK(std::abs(x.y() - y) < 1e-12 * P + 1e-6 * std::abs(y));
    CHECK(std::abs(x.z() - z) < 1e-12 * P + 1e-6 * std::abs(z));
  }
}

TEST_CASE("the axis turns with the needle", "[needle][centreline]") {
  std::mt19937 generator(32);
  const Needle needle = sample_needle(section_with_shear(9.0, 14.0), false);
  const NeedleState state = sample_state(needle, 0.2, generator);
  for (const double angle : {0.5, 3.0, std::numbers::pi, 2.0 * std::numbers::pi, 9.0}) {
    const Eigen::Matrix3d Q = turn_about_random_axis(angle, generator);
    const Eigen::Vector3d b = random_vector(generator);
    NeedleState turned = state;
    turned.positions = (Q * state.positions).colwise() + b;
    for (Eigen::Matrix3d& R : turned.rotations) R = Q * R;
    for (const CentrelinePoint point : {CentrelinePoint{0, 0.3}, CentrelinePoint{2, 0.77}, CentrelinePoint{3, 1.0}}) {
      const Eigen::Vector3d expected = Q * centreline_position(needle, state, point) + b;
      CHECK((centreline_position(needle, turned, point) - expected).norm() < 1e-14);
      const Eigen::Vector3d tangent = Q * centreline_tangent(needle, state, point);
      CHECK((centreline_tangent(needle, turned, point) - tangent).norm() < 1e-14);
    }
  }
}

TEST_CASE("the axis's velocity is the derivative of its place by the configuration", "[needle][centreline]") {
  std::mt19937 generator(33);
  const bool shear = GENERATE(false, true);
  const double size = GENERATE(0.0, 0.1, 0.4);
  const double share = GENERATE(0.0, 0.31, 0.5, 0.93, 1.0);
  CAPTURE(shear, size, share);
  const double GA = shear ? 1.0 : infinite;
  const Needle needle = sample_needle(section_with_shear(2.0 * GA, 3.0 * GA), false);
  const NeedleState state = sample_state(needle, size, generator);
  const CentrelinePoint point{1, share};
  const auto N = centreline_velocity(needle, state, point);
  constexpr double h = 1e-3;
  for (int dof = 0; dof < 12; ++dof) {
    CAPTURE(dof);
    const auto at = [&](double amount) {
      NeedleState nudged = state;
      displace(amount * Eigen::VectorXd::Unit(needle.dof_count(), 6 + dof), nudged);
      return centreline_position(needle, nudged, point);
    };
    // Extrapolated once: h⁴ and round-off over h, both 1e-12 of the size.
    const Eigen::Vector3d near = (at(h) - at(-h)) / (2.0 * h), far = (at(2.0 * h) - at(-2.0 * h)) / (4.0 * h);
    const Eigen::Vector3d derivative = (4.0 * near - far) / 3.0;
    CHECK((N.col(dof) - derivative).norm() < 1e-10);
  }
  // A rigid motion moves the point as a rigid body does.
  const Eigen::Vector3d omega = random_vector(generator), v = random_vector(generator);
  Eigen::Matrix<double, 12, 1> motion;
  for (int i = 0; i < 2; ++i)
    motion.segment<6>(6 * i) << v + omega.cross(Eigen::Vector3d(state.positions.col(1 + i))), omega;
  const Eigen::Vector3d expected = v + omega.cross(centreline_position(needle, state, point));
  CHECK((N * motion - expected).norm() < 1e-14 * 4.0);
}

TEST_CASE("the tangent is the direction in which the place moves with the share", "[needle][centreline]") {
  std::mt19937 generator(34);
  const Needle needle = sample_needle(section_with_shear(9.0, 14.0), false);
  const NeedleState state = sample_state(needle, 0.2, generator);
  for (const double share : {0.1, 0.5, 0.8}) {
    constexpr double h = 1e-5;
    const Eigen::Vector3d step =
        centreline_position(needle, state, {2, share + h}) - centreline_position(needle, state, {2, share - h});
    CHECK((centreline_tangent(needle, state, {2, share}) - step.normalized()).norm() < 1e-9);
  }
}

TEST_CASE("the axis between the nodes of a circle nears it with fourth order", "[needle][centreline]") {
  // Nodes on a unit circle, sections across it, chords as long as the arc's so that the rest is straight.
  ErrorSeries series{"distance from the circle", {}, {}};
  for (const int n : {4, 8, 16, 32}) {
    const double angle = std::numbers::pi / n;
    Eigen::Matrix3Xd nodes = Eigen::Matrix3Xd::Zero(3, n + 1);
    for (int i = 0; i <= n; ++i) nodes(0, i) = i * angle;
    const Needle needle = chain_of_beams(section_with_shear(infinite, infinite), nodes, Eigen::Vector3d::UnitY());
    NeedleState state = needle_at_rest(needle);
    for (int i = 0; i <= n; ++i) {
      state.positions.col(i) << std::sin(i * angle), 1.0 - std::cos(i * angle), 0.0;
      state.rotations[i] = rotation_of({0.0, 0.0, i * angle});
    }
    double error = 0.0;
    for (int k = 1; k < 8; ++k)
      error = std::max(
          error,
          std::abs((centreline_position(needle, state, {n / 2, k / 8.0}) - Eigen::Vector3d::UnitY()).norm() - 1.0));
    series.h.push_back(angle);
    series.error.push_back(error);
  }
  INFO(convergence_table({series}));
  CHECK_THAT(last_order(series), WithinAbs(4.0, 0.1));
}

TEST_CASE("arc length and its inverse agree, and end at the ends", "[needle][centreline]") {
  const Needle needle = sample_needle(section_with_shear(9.0, 14.0), false);
  double whole = 0.0;
  for (int e = 0; e < 4; ++e) whole += (needle.rest_positions.col(e + 1) - needle.rest_positions.col(e)).norm();
  CHECK_THAT(arc_length(needle, {3, 1.0}), WithinRel(whole, 1e-15));
  CHECK(arc_length(needle, {0, 0.0}) == 0.0);
  for (const double share : {0.0, 0.2, 0.7, 0.99, 1.0})
    CHECK_THAT(arc_length(needle, at_arc_length(needle, share * whole)), WithinAbs(share * whole, 1e-15 * whole));
  CHECK(at_arc_length(needle, 0.3 * whole).element == 1);
  CHECK(at_arc_length(needle, -1.0).element == 0);
  CHECK(at_arc_length(needle, -1.0).share == 0.0);
  CHECK(at_arc_length(needle, 2.0 * whole).element == 3);
  CHECK(at_arc_length(needle, 2.0 * whole).share == 1.0);
}

TEST_CASE("the closest point is the closest of a thousand, and looks at x squarely", "[needle][centreline]") {
  std::mt19937 generator(35);
  const Needle needle = sample_needle(section_with_shear(9.0, 14.0), false);
  const NeedleState state = sample_state(needle, 0.2, generator);
  int inside = 0, past = 0;
  for (int trial = 0; trial < 200; ++trial) {
    CAPTURE(trial);
    const Eigen::Vector3d x = Eigen::Vector3d(1.5, 0.4, 0.3) + 2.5 * random_vector(generator);
    const ClosestPoint closest = closest_point(needle, state, x);
    const Eigen::Vector3d offset = x - centreline_position(needle, state, closest.point);
    CHECK_THAT(closest.distance, WithinRel(offset.norm(), 1e-14));
    double brute = std::numeric_limits<double>::infinity();
    for (int e = 0; e < 4; ++e)
      for (int k = 0; k <= 250; ++k)
        brute = std::min(brute, (centreline_position(needle, state, {e, k / 250.0}) - x).norm());
    CHECK(closest.distance <= brute * (1.0 + 1e-14));
    CHECK(closest.distance > brute - 0.01);  // the spacing of the thousand
    if (closest.point.share > 0.0 && closest.point.share < 1.0) {
      ++inside;
      CHECK(std::abs(offset.dot(centreline_tangent(needle, state, closest.point))) < 1e-13);
      CHECK(closest.distance_past_tip == 0.0);
    }
    if (closest.distance_past_tip > 0.0) {
      ++past;
      CHECK(closest.point.element == 3);
      CHECK(closest.point.share == 1.0);
      CHECK_THAT(closest.distance_past_tip, WithinRel(offset.dot(centreline_tangent(needle, state, {3, 1.0})), 1e-13));
    }
  }
  CHECK(inside > 50);
  CHECK(past > 10);
}

TEST_CASE("a point of the axis is its own closest point", "[needle][centreline]") {
  std::mt19937 generator(36);
  const Needle needle = sample_needle(section_with_shear(9.0, 14.0), true);
  const NeedleState state = sample_state(needle, 0.15, generator);
  for (int e = 0; e < 4; ++e)
    for (const double share : {0.0, 0.13, 0.5, 0.875, 1.0}) {
      CAPTURE(e, share);
      const Eigen::Vector3d x = centreline_position(needle, state, {e, share});
      const ClosestPoint closest = closest_point(needle, state, x);
      CHECK(closest.distance < 1e-14);
      CHECK_THAT(closest.point.element + closest.point.share, WithinAbs(e + share, 1e-13));
    }
}
