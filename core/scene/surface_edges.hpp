#pragma once

#include <array>
#include <vector>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// An edge as one of its triangles runs through it.
struct SurfaceEdge {
  int low, high;  ///< its vertices, low < high
  int triangle;
  bool forward;  ///< the triangle runs from low to high
};

/// Three per triangle, by (low, high, triangle), so that the triangles of an edge stand together. Triangles with a
/// repeated vertex have none.
std::vector<SurfaceEdge> surface_edges(const std::vector<std::array<int, 3>>& triangles);

/// The triangles that meet at edges of exactly two triangles, piece by piece: the piece of each triangle, numbered by
/// first appearance.
struct SurfacePieces {
  std::vector<int> of_triangle;
  int count = 0;
};
SurfacePieces connected_pieces(const std::vector<SurfaceEdge>& edges, std::size_t triangles);

/// Turns triangles so that neighbours run through their edge in opposite directions, as the first triangle of each
/// piece; on a surface where this cannot be (a Möbius strip) some edges are left as they are.
void orient_as_neighbours(std::vector<std::array<int, 3>>& triangles);

}  // namespace finegauge
