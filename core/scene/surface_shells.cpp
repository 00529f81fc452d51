#include "core/scene/surface_shells.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace finegauge {
namespace {

bool inside_box(const Shell& shell, const Eigen::Vector3d& x) {
  return (shell.low.array() <= x.array()).all() && (x.array() <= shell.high.array()).all();
}

}  // namespace

int winding_number(const TriangleSurface& surface, const std::vector<int>& triangles, const Eigen::Vector3d& x) {
  double half_angles = 0.0;
  for (const int t : triangles) {
    const auto& corners = surface.triangles[static_cast<std::size_t>(t)];
    const Eigen::Vector3d a = (surface.vertices.col(corners[0]) - x).normalized();
    const Eigen::Vector3d b = (surface.vertices.col(corners[1]) - x).normalized();
    const Eigen::Vector3d c = (surface.vertices.col(corners[2]) - x).normalized();
    half_angles += std::atan2(a.dot(b.cross(c)), 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
  }
  return static_cast<int>(std::lround(half_angles / (2.0 * std::numbers::pi)));
}

std::vector<Shell> surface_shells(const TriangleSurface& surface, const SurfacePieces& pieces) {
  std::vector<Shell> shells(static_cast<std::size_t>(pieces.count));
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    shells[static_cast<std::size_t>(pieces.of_triangle[t])].triangles.push_back(static_cast<int>(t));
  const auto vertex_of = [&](int t, std::size_t k) -> Eigen::Vector3d {
    return surface.vertices.col(surface.triangles[static_cast<std::size_t>(t)][k]);
  };
  for (Shell& shell : shells) {
    const Eigen::Vector3d origin = vertex_of(shell.triangles.front(), 0);  // on the shell, or a far body would cancel
    shell.low = shell.high = origin;
    for (const int t : shell.triangles) {
      const Eigen::Vector3d a = vertex_of(t, 0), b = vertex_of(t, 1), c = vertex_of(t, 2);
      shell.volume += (a - origin).dot((b - origin).cross(c - origin)) / 6.0;
      shell.area += (b - a).cross(c - a).norm() / 2.0;
      shell.low = shell.low.cwiseMin(a).cwiseMin(b).cwiseMin(c);
      shell.high = shell.high.cwiseMax(a).cwiseMax(b).cwiseMax(c);
    }
  }
  for (std::size_t s = 0; s < shells.size(); ++s) {
    const Eigen::Vector3d x = vertex_of(shells[s].triangles.front(), 0);
    for (std::size_t other = 0; other < shells.size(); ++other)
      if (other != s && inside_box(shells[other], x) && winding_number(surface, shells[other].triangles, x) != 0)
        shells[s].around.push_back(static_cast<int>(other));
  }
  return shells;
}

}  // namespace finegauge
