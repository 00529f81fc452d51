#include "core/mesh/selection_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace finegauge {
namespace {

/// Distance of a point from a selection [m]; not above zero inside.
double distance_to(const BoxSelection& box, const Eigen::Vector3d& x) {
  return (box.min - x).cwiseMax(x - box.max).cwiseMax(0.0).norm();
}
double distance_to(const SphereSelection& sphere, const Eigen::Vector3d& x) {
  return (x - sphere.centre).norm() - sphere.radius;
}
double distance_to(const PatchSelection& patch, const Eigen::Vector3d& x) {
  return (x - patch.point).norm() - patch.radius;
}

}  // namespace

double selection_slack(const Eigen::Matrix3Xd& points) {
  constexpr double share = 1e-9;
  return share * (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
}

Selected select_points(const Eigen::Matrix3Xd& points, const Selection& selection, double slack) {
  Selected chosen;
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d x = points.col(i);
    const double outside = std::visit([&](const auto& shape) { return distance_to(shape, x); }, selection);
    if (outside <= slack)
      chosen.numbers.push_back(static_cast<int>(i));
    else
      nearest = std::min(nearest, outside);
  }
  if (chosen.numbers.empty()) chosen.nearest_outside = nearest;
  return chosen;
}

}  // namespace finegauge
