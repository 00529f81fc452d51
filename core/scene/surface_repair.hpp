#pragma once

#include <array>
#include <vector>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// Repairs that leave the surface in space as it is. Each returns how many it changed, or more.

/// Vertices that no triangle uses are dropped; the others keep their order.
int drop_unused_vertices(TriangleSurface& surface);

/// Vertices with exactly equal coordinates become the first of them; the others are dropped.
struct MergedVertices {
  int count = 0;                                    ///< dropped
  Eigen::Vector3d first = Eigen::Vector3d::Zero();  ///< where the first dropped one stood
};
MergedVertices merge_equal_vertices(TriangleSurface& surface);

/// Triangles that name a vertex twice are dropped: their other sides are one edge run through both ways, so that their
/// neighbours meet there. `numbers` (of each triangle) loses the same entries.
int drop_collapsed_triangles(TriangleSurface& surface, std::vector<int>& numbers);

/// A triangle of zero area whose three vertices differ is a split in the long side of its neighbour: the neighbour is
/// cut in two at the middle vertex. `flat` are all of them, with the corner that lies between the other two. The
/// triangles of a pair keep their places. Those are left that have no single neighbour at the long side, or one that
/// was changed in the same call: call again with what is flat then.
struct FlatTriangle {
  int triangle;
  int middle;  ///< corner, 0 to 2
};
int split_at_flat_triangles(TriangleSurface& surface, const std::vector<FlatTriangle>& flat);

}  // namespace finegauge
