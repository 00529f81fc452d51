#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// Vertices in the order of their first use, as a file without shared vertices (STL) gives them.
inline TriangleSurface numbered_by_use(const TriangleSurface& surface) {
  TriangleSurface result{surface.vertices, surface.triangles};
  std::vector<int> number(static_cast<std::size_t>(surface.vertices.cols()), -1);
  int used = 0;
  for (auto& corners : result.triangles)
    for (int& vertex : corners) {
      int& to = number[static_cast<std::size_t>(vertex)];
      if (to < 0) {
        to = used++;
        result.vertices.col(to) = surface.vertices.col(vertex);
      }
      vertex = to;
    }
  result.vertices.conservativeResize(Eigen::NoChange, used);
  return result;
}

/// An octahedron whose triangles are cut in four `level` times, pushed out to the sphere: 8 · 4^level triangles,
/// vertices numbered by first use. Coordinates are rounded to floats, so that every file format holds them.
inline TriangleSurface octasphere(int level, double radius, const Eigen::Vector3d& centre) {
  std::vector<Eigen::Vector3d> points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<int, 3>> triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                               {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [place, added] = middles.try_emplace(std::minmax(a, b), static_cast<int>(points.size()));
      if (added)
        points.push_back((points[static_cast<std::size_t>(a)] + points[static_cast<std::size_t>(b)]).normalized());
      return place->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = finer;
  }
  TriangleSurface surface;
  surface.triangles = triangles;
  surface.vertices.resize(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i)
    surface.vertices.col(static_cast<Eigen::Index>(i)) = (centre + radius * points[i]).cast<float>().cast<double>();
  return numbered_by_use(surface);
}

/// Both in one surface.
inline TriangleSurface together(const TriangleSurface& a, const TriangleSurface& b) {
  TriangleSurface both = a;
  both.vertices.conservativeResize(Eigen::NoChange, a.vertices.cols() + b.vertices.cols());
  both.vertices.rightCols(b.vertices.cols()) = b.vertices;
  const auto first = static_cast<int>(a.vertices.cols());
  for (const auto& [i, j, k] : b.triangles) both.triangles.push_back({first + i, first + j, first + k});
  return both;
}

inline TriangleSurface turned(TriangleSurface surface) {
  for (auto& corners : surface.triangles) std::swap(corners[1], corners[2]);
  return surface;
}

/// What it encloses, by the divergence theorem over its triangles: not the formula of the core, which it judges.
inline double volume_by_divergence(const TriangleSurface& surface) {
  double volume = 0.0;
  for (const auto& [a, b, c] : surface.triangles) {
    Eigen::Matrix3d corners;
    corners << surface.vertices.col(a), surface.vertices.col(b), surface.vertices.col(c);
    volume += (corners(0, 0) * (corners(1, 1) * corners(2, 2) - corners(2, 1) * corners(1, 2)) -
               corners(0, 1) * (corners(1, 0) * corners(2, 2) - corners(2, 0) * corners(1, 2)) +
               corners(0, 2) * (corners(1, 0) * corners(2, 1) - corners(2, 0) * corners(1, 1))) /
              6.0;
  }
  return volume;
}

}  // namespace finegauge
