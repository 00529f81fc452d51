#include "core/needle/rotation_vector.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace finegauge {

namespace {

/// η = (1 - (θ/2) cot(θ/2)) / θ² and its derivative by θ².
struct TangentCoefficients {
  double eta, eta_slope;
};
TangentCoefficients tangent_coefficients(double theta_squared) {
  const double x = theta_squared;
  if (x < 0.5) {
    // |B_2k| / (2k)! x^(k-1) (Bernoulli numbers): the terms fall by x / 4π² each, below 1e-15 after eight.
    constexpr double b[] = {1.0 / 12,
                            1.0 / 720,
                            1.0 / 30240,
                            1.0 / 1209600,
                            1.0 / 47900160,
                            691.0 / 1307674368000.0,
                            1.0 / 74724249600.0,
                            3617.0 / 10670622842880000.0};
    double eta = 0.0, slope = 0.0;
    for (int k = 7; k >= 0; --k) {
      slope = slope * x + eta;
      eta = eta * x + b[k];
    }
    return {eta, slope};
  }
  const double half = 0.5 * std::sqrt(x);
  const double y = half / std::tan(half);
  const double eta = (1.0 - y) / x;
  const double y_slope = (y - y * y - 0.25 * x) / (2.0 * x);
  return {eta, -(eta + y_slope) / x};
}

}  // namespace

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d A;
  A << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return A;
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& a) {
  const double angle = a.norm();
  if (!(angle > 0.0)) return Eigen::Matrix3d::Identity() + cross_matrix(a);  // passes NaN on
  const double half_sine = std::sin(0.5 * angle) / angle;
  const Eigen::Matrix3d A = cross_matrix(a);
  return Eigen::Matrix3d::Identity() + std::sin(angle) / angle * A + 2.0 * half_sine * half_sine * A * A;
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  return (sine > 0.0 ? 2.0 * std::atan2(sine, q.w()) / sine : 2.0) * q.vec();
}

Eigen::Matrix3d orthonormalized(const Eigen::Matrix3d& R) {
  return 0.5 * R * (3.0 * Eigen::Matrix3d::Identity() - R.transpose() * R);
}

Eigen::Matrix3d inverse_rotation_tangent(const Eigen::Vector3d& Theta) {
  const double eta = tangent_coefficients(Theta.squaredNorm()).eta;
  const Eigen::Matrix3d A = cross_matrix(Theta);
  return Eigen::Matrix3d::Identity() - 0.5 * A + eta * A * A;
}

Eigen::Matrix3d derivative_of_transposed_tangent(const Eigen::Vector3d& Theta, const Eigen::Vector3d& m) {
  // T⁻ᵀ m = m + Θ × m / 2 + η (Θ (Θ·m) - m Θ·Θ).
  const auto [eta, eta_slope] = tangent_coefficients(Theta.squaredNorm());
  const double projection = Theta.dot(m);
  const Eigen::Vector3d twice_crossed = Theta * projection - m * Theta.squaredNorm();
  return -0.5 * cross_matrix(m) +
         eta * (projection * Eigen::Matrix3d::Identity() + Theta * m.transpose() - 2.0 * m * Theta.transpose()) +
         2.0 * eta_slope * twice_crossed * Theta.transpose();
}

}  // namespace finegauge
