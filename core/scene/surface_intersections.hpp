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
  bool all = true;                        ///< false: there are more, and the search stopped
  std::size_t decided = 0;                ///< pairs that were decided exactly
};
/// Pairs of triangles that have more in common than the vertex or the edge that they share. No triangle may be flat,
/// and no two may have the same vertices. Those around a vertex are sorted by where they are seen from it, all others
/// by boxes turned as they lie: n log n pairs are compared where triangles are small, and in flat fans of thousands.
Intersections intersecting_triangles(const TriangleSurface& surface, std::size_t most_pairs);

}  // namespace finegauge
