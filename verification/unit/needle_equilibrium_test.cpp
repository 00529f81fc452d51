#include "core/needle/needle_equilibrium.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/needle/rotation_vector.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// A phantom needle: E = 50 MPa, r = 1 mm, 32 mm long, along x.
const NeedleProperties soft_steel = {.youngs_modulus = 5e7};
constexpr double L = 0.032;
Needle phantom_needle(int elements) { return straight_needle(soft_steel, {0.0, 0.0, 0.0}, {L, 0.0, 0.0}, elements); }
double bending_stiffness() { return round_section(soft_steel).EI_2; }

HeldDofs clamped_base(const Needle& needle) {
  HeldDofs held(needle.node_count(), 0u);
  held[0] = hold_all;
  return held;
}
NeedleLoad tip_load(const Needle& needle, const Eigen::Vector3d& force, const Eigen::Vector3d& moment) {
  NeedleLoad load;
  load.reference = Eigen::VectorXd::Zero(needle.dof_count());
  load.reference.tail<6>() << force, moment;
  return load;
}

}  // namespace

TEST_CASE("a straight needle loses its stability at Euler's load, in both planes at once", "[needle][equilibrium]") {
  // π² EI / (2 L)² = 0.0946 N fixed and free, and 20.19 EI / L² = 0.774 N fixed and pinned (less shear, 12 EI / GA L² =
  // 1e-2); 16 elements are within 1 % of it.
  const bool pinned = GENERATE(false, true);
  const double factor = pinned ? 4.4934094579 * 4.4934094579 : 0.25 * std::numbers::pi * std::numbers::pi;
  const double critical = factor * bending_stiffness() / (L * L);
  CHECK_THAT(critical, WithinRel(pinned ? 0.774 : 0.0946, 1e-3));
  const Needle needle = phantom_needle(16);
  HeldDofs held = clamped_base(needle);
  if (pinned) held.back() = 6u;
  for (const double share : {0.5, 0.97, 1.03, 2.0}) {
    CAPTURE(pinned, share);
    const NeedleLoad load = tip_load(needle, {-share * critical, 0.0, 0.0}, Eigen::Vector3d::Zero());
    const NeedleEquilibrium result = solve_needle_equilibrium(needle, held, load, needle_at_rest(needle));
    REQUIRE(result.converged);
    CHECK(result.negative_pivots == (share < 1.0 ? 0 : 2));
    CHECK(result.state.positions.bottomRows<2>().cwiseAbs().maxCoeff() < 1e-12 * L);  // straight by symmetry alone
  }
}

TEST_CASE("a step that is too long is returned as not converged, with the last state that was",
          "[needle][equilibrium]") {
  const Needle needle = phantom_needle(16);
  const double moment = 8.0 * std::numbers::pi * bending_stiffness() / L;
  const NeedleLoad load = tip_load(needle, Eigen::Vector3d::Zero(), {0.0, 0.0, moment});
  const NeedleState rest = needle_at_rest(needle);
  const NeedleEquilibrium result =
      solve_needle_equilibrium(needle, clamped_base(needle), load, rest, {.steps = 1, .iterations = 6});
  CHECK_FALSE(result.converged);
  CHECK(result.load_factor == 0.0);
  CHECK(result.iterations <= 6);
  CHECK(result.relative_residual > 1e-6);
  CHECK((result.state.positions - rest.positions).norm() == 0.0);
  // No clamp: the tangent of a free needle is singular.
  const NeedleEquilibrium free =
      solve_needle_equilibrium(needle, HeldDofs(needle.node_count(), 0u), load, rest, {.steps = 1});
  CHECK_FALSE(free.converged);
}

TEST_CASE("a load that makes no number is not converged, and no NaN is handed on", "[needle][equilibrium]") {
  const Needle needle = phantom_needle(4);
  const NeedleLoad load =
      tip_load(needle, {0.0, std::numeric_limits<double>::quiet_NaN(), 0.0}, Eigen::Vector3d::Zero());
  const NeedleEquilibrium result = solve_needle_equilibrium(needle, clamped_base(needle), load, needle_at_rest(needle));
  CHECK_FALSE(result.converged);
  CHECK(result.state.positions.allFinite());
}

TEST_CASE("a needle at rest without load, and one that was moved as a whole, are in equilibrium",
          "[needle][equilibrium]") {
  const Needle needle = phantom_needle(8);
  NeedleState state = needle_at_rest(needle);
  const Eigen::Matrix3d Q = rotation_of({2.0, -5.0, 1.0});
  state.positions = (Q * state.positions).colwise() + Eigen::Vector3d(0.1, 0.2, -0.3);
  for (Eigen::Matrix3d& R : state.rotations) R = Q * R;
  const NeedleEquilibrium result = solve_needle_equilibrium(needle, clamped_base(needle), {}, state);
  CHECK(result.converged);
  CHECK(result.iterations <= 5);
  CHECK((result.state.positions - state.positions).cwiseAbs().maxCoeff() < 1e-14);  // round-off of 0.3 m
}

TEST_CASE("held dofs stay, the fixed load acts at every load factor, velocities end", "[needle][equilibrium]") {
  const Needle needle = phantom_needle(8);
  const double P = bending_stiffness() / (L * L);
  NeedleState start = needle_at_rest(needle);
  start.positions.col(0) += Eigen::Vector3d(1e-4, -2e-3, 0.0);
  start.rotations[0] = rotation_of({0.0, 0.0, 0.2});
  start.velocities.setConstant(3.0);
  NeedleLoad both, fixed;
  both.reference = fixed.fixed = tip_load(needle, {0.0, P, 0.0}, Eigen::Vector3d::Zero()).reference;
  both.fixed = tip_load(needle, {0.0, 0.0, 0.5 * P}, Eigen::Vector3d::Zero()).reference;
  fixed.fixed += both.fixed;
  const NeedleEquilibrium one = solve_needle_equilibrium(needle, clamped_base(needle), both, start, {.steps = 4});
  const NeedleEquilibrium other = solve_needle_equilibrium(needle, clamped_base(needle), fixed, start);
  REQUIRE(one.converged);
  REQUIRE(other.converged);
  CHECK(one.load_factor == 1.0);
  CHECK(one.negative_pivots == 0);
  CHECK((one.state.positions - other.state.positions).norm() < 1e-10 * L);
  CHECK((one.state.positions.col(0) - start.positions.col(0)).norm() == 0.0);
  CHECK((one.state.rotations[0] - start.rotations[0]).norm() < 1e-15);
  CHECK(one.state.velocities.norm() == 0.0);
  CHECK((one.state.positions.rightCols<1>() - needle.rest_positions.rightCols<1>()).norm() > 0.2 * L);
  // The clamp carries the load: forces sum to zero.
  const Eigen::VectorXd forces = needle_forces(needle, one.state);
  CHECK((forces.head<3>() + Eigen::Vector3d(0.0, P, 0.5 * P)).norm() < 1e-10 * P);
}

TEST_CASE("an applied moment out of the plane of bending converges though the tangent is its symmetric part",
          "[needle][equilibrium]") {
  const Needle needle = phantom_needle(12);
  const double M = bending_stiffness() / L;
  const NeedleLoad load = tip_load(needle, {0.0, M / L, 0.0}, {0.6 * M, 0.8 * M, 0.5 * M});
  const NeedleEquilibrium result =
      solve_needle_equilibrium(needle, clamped_base(needle), load, needle_at_rest(needle), {.steps = 2});
  CAPTURE(result.iterations, result.relative_residual);
  REQUIRE(result.converged);
  CHECK((needle_forces(needle, result.state).tail<6>() - load.reference.tail<6>()).norm() <
        1e-9 * load.reference.tail<6>().norm());
}
