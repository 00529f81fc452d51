#include "core/mesh/triangle_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <limits>

namespace finegauge {

BoundingBox bounding_box(const TriangleSurface& surface) {
  assert(!surface.triangles.empty());
  constexpr double infinity = std::numeric_limits<double>::infinity();
  BoundingBox box{Eigen::Vector3d::Constant(infinity), Eigen::Vector3d::Constant(-infinity)};
  for (const auto& triangle : surface.triangles)
    for (const int vertex : triangle) {
      box.lower = box.lower.cwiseMin(surface.vertices.col(vertex));
      box.upper = box.upper.cwiseMax(surface.vertices.col(vertex));
    }
  return box;
}

EnclosedSolid enclosed_solid(const TriangleSurface& surface) {
  EnclosedSolid solid{0.0, Eigen::Vector3d::Zero()};
  if (surface.triangles.empty()) return solid;
  const BoundingBox box = bounding_box(surface);
  const Eigen::Vector3d middle = 0.5 * (box.lower + box.upper);
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int triangle = 0; triangle < surface.triangle_count(); ++triangle) {
    const Eigen::Matrix3d corners = triangle_corners(surface, triangle).colwise() - middle;
    const double six_volumes = corners.col(0).dot(corners.col(1).cross(corners.col(2)));
    solid.volume += six_volumes / 6.0;
    moment += six_volumes / 24.0 * corners.rowwise().sum();
  }
  solid.centroid = middle;
  if (solid.volume != 0.0) solid.centroid += moment / solid.volume;
  return solid;
}

std::optional<OpenEdge> open_edge(const TriangleSurface& surface) {
  const auto X = [&](int vertex) { return surface.vertices.col(vertex); };
  const auto before = [&](int a, int b) {
    return std::lexicographical_compare(X(a).begin(), X(a).end(), X(b).begin(), X(b).end());
  };
  std::vector<int> order;
  for (const auto& triangle : surface.triangles) order.insert(order.end(), triangle.begin(), triangle.end());
  std::sort(order.begin(), order.end(), before);
  std::vector<int> rank(surface.vertices.cols(), -1);
  std::vector<int> at;  // a vertex of each rank
  for (const int vertex : order) {
    if (at.empty() || before(at.back(), vertex)) at.push_back(vertex);
    rank[vertex] = static_cast<int>(at.size()) - 1;
  }
  std::vector<std::array<int, 3>> walks;  // lower rank, higher rank, direction
  walks.reserve(3 * surface.triangles.size());
  for (const auto& triangle : surface.triangles)
    for (int c = 0; c < 3; ++c) {
      const int from = rank[triangle[c]], to = rank[triangle[(c + 1) % 3]];
      if (from != to) walks.push_back({std::min(from, to), std::max(from, to), from < to ? 1 : -1});
    }
  std::sort(walks.begin(), walks.end());
  for (std::size_t i = 0; i < walks.size();) {
    const auto [low, high, unused] = walks[i];
    int balance = 0;
    for (; i < walks.size() && walks[i][0] == low && walks[i][1] == high; ++i) balance += walks[i][2];
    if (balance > 0) return OpenEdge{X(at[low]), X(at[high])};
    if (balance < 0) return OpenEdge{X(at[high]), X(at[low])};
  }
  return std::nullopt;
}

double enclosed_volume(const TriangleSurface& surface) { return enclosed_solid(surface).volume; }

double area(const TriangleSurface& surface) {
  double sum = 0.0;
  for (int triangle = 0; triangle < surface.triangle_count(); ++triangle) {
    const Eigen::Matrix3d corners = triangle_corners(surface, triangle);
    sum += 0.5 * (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0)).norm();
  }
  return sum;
}

}  // namespace finegauge
