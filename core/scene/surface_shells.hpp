#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/scene/surface_edges.hpp"

namespace finegauge {

/// A piece of a surface, closed and consistently oriented.
struct Shell {
  std::vector<int> triangles;
  Eigen::Vector3d low, high;  ///< box [length of the file]
  double volume = 0.0;        ///< enclosed, > 0 when its triangles are counter-clockwise seen from outside
  double area = 0.0;
  std::vector<int> around;  ///< shells that enclose it, ascending
};

/// The shells of a surface without boundary and without intersections, each with those that enclose it: the winding
/// number of one of its vertices, by solid angles (Van Oosterom & Strackee 1983, IEEE Trans. Biomed. Eng. 30, 125-126).
std::vector<Shell> surface_shells(const TriangleSurface& surface, const SurfacePieces& pieces);

/// How often the surface of these triangles winds around x, positive when counter-clockwise seen from outside; x does
/// not lie on it.
int winding_number(const TriangleSurface& surface, const std::vector<int>& triangles, const Eigen::Vector3d& x);

}  // namespace finegauge
