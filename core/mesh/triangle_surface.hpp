#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

namespace finegauge {

/// A closed surface of triangles, corners counter-clockwise seen from outside.
struct TriangleSurface {
  Eigen::Matrix3Xd vertices;                  ///< [m], 3 × vertices
  std::vector<std::array<int, 3>> triangles;  ///< corner vertices

  int triangle_count() const { return static_cast<int>(triangles.size()); }
};

/// The corners of one triangle in columns [m].
inline Eigen::Matrix3d triangle_corners(const TriangleSurface& surface, int triangle) {
  Eigen::Matrix3d corners;
  for (int c = 0; c < 3; ++c) corners.col(c) = surface.vertices.col(surface.triangles[triangle][c]);
  return corners;
}

/// What a closed surface encloses, by the divergence theorem (Zhang & Chen 2001): tetrahedra between each triangle and
/// a point amid the surface, so that a body far from the origin loses no digits. Negative volume: the triangles are
/// seen from inside. The surface must be closed; of an open one the numbers mean nothing.
struct EnclosedSolid {
  double volume;             ///< [m³], with sign
  Eigen::Vector3d centroid;  ///< [m]; that of the vertices where the volume is zero
};
EnclosedSolid enclosed_solid(const TriangleSurface& surface);
double enclosed_volume(const TriangleSurface& surface);
double area(const TriangleSurface& surface);  ///< [m²]

/// The ends of an edge that is not walked as often in one direction as in the other, first in lexicographic order of
/// coordinates; none when the surface is closed. Vertices at the same place count as one. [m]
struct OpenEdge {
  Eigen::Vector3d from, to;
};
std::optional<OpenEdge> open_edge(const TriangleSurface& surface);

/// Smallest box around the corners of the triangles; vertices that no triangle uses do not count. [m]
/// Precondition: at least one triangle.
struct BoundingBox {
  Eigen::Vector3d lower, upper;
};
BoundingBox bounding_box(const TriangleSurface& surface);

}  // namespace finegauge
