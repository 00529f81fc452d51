#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace finegauge {

/// A function of three coordinates at a point: value, gradient and Hessian. Forward automatic differentiation to second
/// order, so that sources of manufactured solutions need no derivative by hand.
struct Jet {
  double value = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();

  Jet() = default;
  Jet(double constant) : value(constant) {}  // implicit: constants appear in formulas
  Jet(double v, const Eigen::Vector3d& g, const Eigen::Matrix3d& h) : value(v), gradient(g), hessian(h) {}
};
using Jets = std::array<Jet, 3>;

/// The coordinates themselves as functions.
inline Jets coordinates_at(const Eigen::Vector3d& X) {
  Jets x;
  for (int i = 0; i < 3; ++i) x[i] = Jet(X[i], Eigen::Vector3d::Unit(i), Eigen::Matrix3d::Zero());
  return x;
}

inline Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.gradient + b.gradient, a.hessian + b.hessian};
}
inline Jet operator-(const Jet& a, const Jet& b) {
  return {a.value - b.value, a.gradient - b.gradient, a.hessian - b.hessian};
}
inline Jet operator*(const Jet& a, const Jet& b) {
  return {a.value * b.value, a.value * b.gradient + b.value * a.gradient,
          a.value * b.hessian + b.value * a.hessian + a.gradient * b.gradient.transpose() +
              b.gradient * a.gradient.transpose()};
}

/// f(a) from f and its first two derivatives at a.value.
inline Jet chain(const Jet& a, double f, double df, double ddf) {
  return {f, df * a.gradient, df * a.hessian + ddf * a.gradient * a.gradient.transpose()};
}
inline Jet sin(const Jet& a) { return chain(a, std::sin(a.value), std::cos(a.value), -std::sin(a.value)); }
inline Jet cos(const Jet& a) { return chain(a, std::cos(a.value), -std::sin(a.value), -std::cos(a.value)); }
inline Jet exp(const Jet& a) { return chain(a, std::exp(a.value), std::exp(a.value), std::exp(a.value)); }

}  // namespace finegauge
