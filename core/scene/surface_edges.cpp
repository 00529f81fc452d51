#include "core/scene/surface_edges.hpp"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>

namespace finegauge {
namespace {

/// The other triangle at each side (corner k to k + 1) of each triangle where exactly two meet, else -1.
std::vector<std::array<int, 3>> neighbours(const std::vector<SurfaceEdge>& edges,
                                           const std::vector<std::array<int, 3>>& triangles) {
  std::vector<std::array<int, 3>> beside(triangles.size(), {-1, -1, -1});
  const auto side = [&](const SurfaceEdge& edge) {
    const auto& corners = triangles[static_cast<std::size_t>(edge.triangle)];
    const int from = edge.forward ? edge.low : edge.high;
    return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), from) - corners.begin());
  };
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    if (end - i != 2) continue;
    beside[static_cast<std::size_t>(edges[i].triangle)][side(edges[i])] = edges[i + 1].triangle;
    beside[static_cast<std::size_t>(edges[i + 1].triangle)][side(edges[i + 1])] = edges[i].triangle;
  }
  return beside;
}

bool runs_through(const std::array<int, 3>& triangle, int from, int to) {
  for (std::size_t k = 0; k < 3; ++k)
    if (triangle[k] == from && triangle[(k + 1) % 3] == to) return true;
  return false;
}

}  // namespace

std::vector<SurfaceEdge> surface_edges(const std::vector<std::array<int, 3>>& triangles) {
  std::vector<SurfaceEdge> edges;
  edges.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& corners = triangles[t];
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = corners[k], to = corners[(k + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), static_cast<int>(t), from < to});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const SurfaceEdge& a, const SurfaceEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return edges;
}

SurfacePieces connected_pieces(const std::vector<SurfaceEdge>& edges, std::size_t triangles) {
  std::vector<int> parent(triangles);
  for (std::size_t t = 0; t < triangles; ++t) parent[t] = static_cast<int>(t);
  const auto root = [&](int t) {
    while (parent[static_cast<std::size_t>(t)] != t) {
      int& above = parent[static_cast<std::size_t>(t)];
      above = parent[static_cast<std::size_t>(above)];
      t = above;
    }
    return t;
  };
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    if (end - i != 2) continue;
    const int a = root(edges[i].triangle), b = root(edges[i + 1].triangle);
    parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  SurfacePieces pieces{std::vector<int>(triangles, -1), 0};
  for (std::size_t t = 0; t < triangles; ++t) {
    const int first = root(static_cast<int>(t));  // never behind t
    pieces.of_triangle[t] =
        first == static_cast<int>(t) ? pieces.count++ : pieces.of_triangle[static_cast<std::size_t>(first)];
  }
  return pieces;
}

void orient_as_neighbours(std::vector<std::array<int, 3>>& triangles) {
  const std::vector<std::array<int, 3>> beside = neighbours(surface_edges(triangles), triangles);
  const std::vector<std::array<int, 3>> as_read = triangles;
  std::vector<std::uint8_t> seen(triangles.size(), 0);
  std::vector<int> reached;
  for (std::size_t first = 0; first < triangles.size(); ++first) {
    if (seen[first]) continue;
    seen[first] = 1;
    reached.assign(1, static_cast<int>(first));
    for (std::size_t i = 0; i < reached.size(); ++i) {
      const auto here = static_cast<std::size_t>(reached[i]);
      for (std::size_t k = 0; k < 3; ++k) {
        const int next = beside[here][k];
        if (next < 0 || seen[static_cast<std::size_t>(next)]) continue;
        seen[static_cast<std::size_t>(next)] = 1;
        reached.push_back(next);
        const int from = as_read[here][k], to = as_read[here][(k + 1) % 3];
        const bool turned = runs_through(triangles[here], to, from);
        auto& corners = triangles[static_cast<std::size_t>(next)];
        if (runs_through(corners, turned ? to : from, turned ? from : to)) std::swap(corners[1], corners[2]);
      }
    }
  }
}

}  // namespace finegauge
