#pragma once

#include <Eigen/Geometry>
#include <cmath>

/// A liver-like body as an implicit shape: the sign of a function tells inside (< 0) from outside. Lengths in
/// centimetres; x from the patient's right to the left, y from front to back, z upwards (the axes of a lying patient's
/// scan, LPS). Not a scan and not a mean of any: its parts were chosen so that the whole has the features that matter
/// to a simulation: a thick right lobe under a dome, a left lobe that tapers to an edge, a hollow underside, a notch in
/// the lower border between the lobes and a groove in the back where the great vein runs.
namespace liver {

using Point = Eigen::Vector3d;

/// About the distance to an ellipsoid with these half axes, negative inside: the first-order one, F/|grad F| with
/// F = |q|² - 1 in unit coordinates, times the share that makes it exact for a sphere (Quilez 2008).
inline double ellipsoid(const Point& p, const Point& centre, const Point& half_axes,
                        const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) {
  const Point q = turn.transpose() * (p - centre);
  const double a = q.cwiseQuotient(half_axes).norm();
  const double b = q.cwiseQuotient(half_axes.cwiseProduct(half_axes)).norm();
  return b > 0.0 ? a * (a - 1.0) / b : -half_axes.minCoeff();
}

/// The smaller of both, rounded over a width k where they are nearly equal (polynomial of degree 2).
inline double smooth_union(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k / 4.0;
}
inline double smooth_difference(double a, double b, double k) { return -smooth_union(-a, b, k); }
inline double smooth_intersection(double a, double b, double k) { return -smooth_union(-a, -b, k); }

inline Eigen::Matrix3d turned_about(const Point& axis, double degrees) {
  return Eigen::AngleAxisd(degrees * M_PI / 180.0, axis.normalized()).toRotationMatrix();
}

/// Negative inside.
inline double shape(const Point& p) {
  // Right lobe, a dome that hangs down at the side; left lobe, flat and drawn out; the body between them.
  const double right = ellipsoid(p, {-4.4, 0.4, -0.4}, {5.8, 6.6, 7.0});
  const double tail = ellipsoid(p, {-5.7, 0.4, -3.8}, {4.1, 5.0, 5.0});
  const double left = ellipsoid(p, {4.2, -1.4, 2.4}, {7.6, 4.3, 3.3}, turned_about({0, 1, 0}, -8.0));
  const double middle = ellipsoid(p, {-0.6, -0.5, 1.4}, {6.0, 5.7, 5.0});
  double body = smooth_union(right, tail, 3.0);
  body = smooth_union(body, middle, 3.0);
  body = smooth_union(body, left, 3.5);

  // The hollow underside faces down, back and to the left.
  body = smooth_difference(body, ellipsoid(p, {4.4, 2.6, -7.2}, {8.8, 7.6, 7.2}), 2.2);
  // Stomach under the left lobe.
  body = smooth_difference(body, ellipsoid(p, {9.8, 3.3, -1.4}, {5.6, 4.7, 4.3}), 2.0);
  // The notch of the round ligament in the lower front border, and the shallow hollow of the gall bladder beside it.
  body = smooth_difference(body, ellipsoid(p, {1.6, -6.4, -2.4}, {1.3, 3.4, 3.4}), 2.2);
  body = smooth_difference(body, ellipsoid(p, {-2.2, -3.8, -6.2}, {1.9, 4.2, 2.6}), 2.2);
  // The groove of the great vein, upright in the back.
  body = smooth_difference(body, ellipsoid(p, {0.8, 6.8, 1.0}, {2.0, 2.2, 14.0}), 1.8);
  return body;
}

}  // namespace liver
