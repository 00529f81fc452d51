#include "core/needle/rotation_vector.hpp"

#include <algorithm>
#include <random>

#include "verification/support/catch.hpp"
#include "verification/support/central_difference.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

TEST_CASE("the logarithm of a rotation undoes the exponential, at every size below a half turn", "[needle][rotation]") {
  std::mt19937 generator(3);
  const double angle = GENERATE(0.0, 1e-300, 1e-160, 1e-9, 1e-4, 0.49, 0.51, 1.0, 2.0, 2.2, 3.0, 3.14159);
  CAPTURE(angle);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d a = angle * random_vector(generator).normalized();
    const Eigen::Matrix3d R = rotation_of(a);
    CHECK((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-15 * 4.0);
    // Of the angle where it is small, else of 1: entries of R have that much.
    CHECK((rotation_vector(R) - a).norm() <= 1e-15 * 8.0 * std::max(angle, 1e-16));
  }
}

TEST_CASE("the tangent of rotation vectors is the derivative of the logarithm, and its own derivative too",
          "[needle][rotation]") {
  std::mt19937 generator(4);
  const double angle = GENERATE(1e-8, 0.1, 0.7, 0.71, 1.5, 2.5);  // the series ends at √0.5 = 0.707
  CAPTURE(angle);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Vector3d Theta = angle * random_vector(generator).normalized(), m = random_vector(generator);
    const Eigen::Matrix3d R = rotation_of(Theta);
    Eigen::Matrix3d T, dT;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = Eigen::Vector3d::Unit(k);
      T.col(k) = difference([&](double h) { return rotation_vector(rotation_of(h * e) * R); }, difference_step);
      dT.col(k) =
          difference([&](double h) { return Eigen::Vector3d(inverse_rotation_tangent(Theta + h * e).transpose() * m); },
                     difference_step);
    }
    CHECK((T - inverse_rotation_tangent(Theta)).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((dT - derivative_of_transposed_tangent(Theta, m)).cwiseAbs().maxCoeff() < 1e-9);
  }
}
