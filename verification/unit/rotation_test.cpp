#include "core/elasticity/rotation.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

/// A dozen operations on numbers of size one: a few times the unit round-off.
constexpr double rotation_round_off = 1e-14;

void check_is_rotation(const Eigen::Matrix3d& R) {
  CHECK_THAT((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(),
             WithinAbs(0.0, rotation_round_off));
  CHECK_THAT(R.determinant(), WithinAbs(1.0, rotation_round_off));
}

/// The definition: no other rotation, near or far, has a larger tr(Rᵀ F). Near ones lose only second order.
void check_is_nearest(const Eigen::Matrix3d& R, const Eigen::Matrix3d& F, std::mt19937& generator) {
  const double size = F.norm();
  const double reached = (R.transpose() * F).trace();
  for (int trial = 0; trial < 200; ++trial) {
    const double angle = std::pow(10.0, -6.0 + 6.5 * std::abs(random_number(generator)));
    const Eigen::Matrix3d other = turn_about_random_axis(angle, generator) * R;
    CHECK((other.transpose() * F).trace() <= reached + 1e-14 * size);
  }
}

Eigen::Matrix3d stretched(const Eigen::Matrix3d& U, const Eigen::Vector3d& stretches, const Eigen::Matrix3d& V) {
  return U * stretches.asDiagonal() * V.transpose();
}

}  // namespace

TEST_CASE("the rotation of a stretched cell is the one it was turned by", "[rotation]") {
  std::mt19937 generator(11);
  const double angle = GENERATE(0.0, 1e-9, 0.1, 1.5707963267948966, 3.14, 3.1415926, 3.141592653589793, 5.0);
  CAPTURE(angle);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Matrix3d turn = turn_about_random_axis(angle, generator);
    const Eigen::Matrix3d V = turn_about_random_axis(3.0 * random_number(generator), generator);
    const Eigen::Vector3d stretches = Eigen::Vector3d(1.3, 1.0, 0.5) + 0.2 * random_vector(generator);
    const Eigen::Matrix3d R = nearest_rotation(turn * stretched(V, stretches, V));
    check_is_rotation(R);
    CHECK_THAT((R - turn).cwiseAbs().maxCoeff(), WithinAbs(0.0, 1e-13));
  }
}

TEST_CASE("exact half turns about the axes are returned as they are", "[rotation]") {
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d signs = Eigen::Vector3d::Constant(-1.0);
    signs[axis] = 1.0;
    const Eigen::Matrix3d half_turn = signs.asDiagonal();
    CHECK((nearest_rotation(half_turn) - half_turn).cwiseAbs().maxCoeff() == 0.0);
  }
}

TEST_CASE("every gradient has a proper rotation, and it is the nearest", "[rotation]") {
  std::mt19937 generator(12);
  const auto [name, stretches] = GENERATE(table<const char*, std::array<double, 3>>({
      {"sound", {1.2, 1.0, 0.7}},
      {"equal", {1.0, 1.0, 1.0}},
      {"inverted", {1.2, 1.0, -0.7}},
      {"barely inverted", {1.2, 1.0, -1e-9}},
      {"barely sound", {1.2, 1.0, 1e-9}},
      {"flat", {1.2, 0.9, 0.0}},
      {"needle", {1.0, 1e-7, 2e-8}},
      {"flat needle", {1.0, 1e-7, 0.0}},
      {"line", {1.0, 0.0, 0.0}},
      {"reflected", {1.0, 1.0, -1.0}},
      {"near the bound between the methods", {1.0, 0.02, 0.0051}},
  }));
  const double size = GENERATE(1.0, 1e-9, 1e9);
  CAPTURE(name, size);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Matrix3d U = turn_about_random_axis(3.0 * random_number(generator), generator);
    const Eigen::Matrix3d V = turn_about_random_axis(3.0 * random_number(generator), generator);
    const Eigen::Matrix3d F = size * stretched(U, Eigen::Vector3d(stretches.data()), V);
    const Eigen::Matrix3d R = nearest_rotation(F);
    check_is_rotation(R);
    check_is_nearest(R, F, generator);
  }
}

TEST_CASE("random gradients, half of them inverted, give the nearest rotation", "[rotation]") {
  std::mt19937 generator(13);
  int inverted = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Matrix3d F = random_matrix(generator);
    inverted += F.determinant() < 0.0;
    const Eigen::Matrix3d R = nearest_rotation(F);
    check_is_rotation(R);
    check_is_nearest(R, F, generator);
  }
  CHECK(inverted > 50);
  CHECK(inverted < 150);
}

TEST_CASE("zero gives the identity, and size alone changes nothing", "[rotation]") {
  CHECK(nearest_rotation(Eigen::Matrix3d::Zero()) == Eigen::Matrix3d::Identity());
  std::mt19937 generator(14);
  const Eigen::Matrix3d turn = turn_about_random_axis(2.0, generator);
  for (const double size : {1e-300, 1e-200, 1e-80, 1e80, 1e200, 1e300}) {
    CAPTURE(size);
    const Eigen::Matrix3d R = nearest_rotation(size * turn);
    check_is_rotation(R);
    CHECK_THAT((R - turn).cwiseAbs().maxCoeff(), WithinAbs(0.0, rotation_round_off));
  }
}

TEST_CASE("a gradient that is not finite is not given a rotation", "[rotation]") {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(1, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK(nearest_rotation(F).hasNaN());
  F(1, 2) = std::numeric_limits<double>::infinity();
  CHECK(nearest_rotation(F).hasNaN());
}
