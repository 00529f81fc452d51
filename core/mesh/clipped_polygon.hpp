#pragma once

#include <Eigen/Core>
#include <array>
#include <cassert>

namespace finegauge {

/// What planes across the axes leave of a triangle: a convex polygon.
///
/// Room for nine corners is enough for any cuts by a box, round-off or not. Along each axis the corners' coordinates
/// rise once and fall once around the polygon: a triangle's do, and a cut deletes corners and inserts, on an edge,
/// points between its ends (cut_point sees to that), which changes nothing about it. So a plane crosses two edges at
/// most, the cut adds one corner at most, and one edge, in its plane. A cut by a plane farther in along the same axis
/// deletes the corners of the edge that the one before it left, since these lie in that plane exactly: of the edges
/// three are the triangle's, and at most one lies in each of the box's six faces.
struct ClippedPolygon {
  std::array<Eigen::Vector3d, 9> corners;
  int count = 0;

  void add(const Eigen::Vector3d& corner) {
    assert(count < static_cast<int>(corners.size()));
    corners[count++] = corner;
  }
};

/// The point of the segment on the plane x[axis] = at; from its lower to its higher end, whoever asks, and no
/// coordinate beyond those of the ends.
inline Eigen::Vector3d cut_point(const Eigen::Vector3d& a, const Eigen::Vector3d& b, int axis, double at) {
  const Eigen::Vector3d &low = a[axis] < b[axis] ? a : b, &high = a[axis] < b[axis] ? b : a;
  Eigen::Vector3d cut = low + (at - low[axis]) / (high[axis] - low[axis]) * (high - low);
  cut = cut.cwiseMax(low.cwiseMin(high)).cwiseMin(low.cwiseMax(high)).eval();
  cut[axis] = at;
  return cut;
}

enum class Side { above, below };

/// The part of the polygon on one side of the plane x[axis] = at (Sutherland & Hodgman 1974).
inline ClippedPolygon clipped(const ClippedPolygon& polygon, int axis, Side side, double at) {
  const auto keeps = [&](const Eigen::Vector3d& x) { return side == Side::above ? x[axis] >= at : x[axis] <= at; };
  ClippedPolygon part;
  for (int c = 0; c < polygon.count; ++c) {
    const Eigen::Vector3d &from = polygon.corners[c], &to = polygon.corners[c + 1 < polygon.count ? c + 1 : 0];
    if (keeps(from)) part.add(from);
    if (keeps(from) != keeps(to)) part.add(cut_point(from, to, axis, at));
  }
  return part;
}

}  // namespace finegauge
