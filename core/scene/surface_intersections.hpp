#pragma once

#include <array>
#include <vector>

#include "core/mesh/triangle_surface.hpp"
#include "core/scene/surface_repair.hpp"

namespace finegauge {

/// Decided exactly: the coordinates are taken as the numbers that they are (CGAL's exact predicates).

/// Triangles of three vertices on one line, ascending. No two vertices of a triangle may coincide.
std::vector<FlatTriangle> flat_triangles(const TriangleSurface& surface);

struct Intersections {
  std::vector<std::array<int, 2>> pairs;  ///< of triangles, each ascending, in ascending order
  bool all = true;                        ///< false: the search stopped at as many as allowed
};
/// Pairs of triangles that have more in common than the vertex or the edge that they share. No triangle may be flat,
/// and no two may have the same vertices. Sorting boxes makes n log n tests of a surface whose triangles are small.
Intersections intersecting_triangles(const TriangleSurface& surface, std::size_t most_pairs);

}  // namespace finegauge
