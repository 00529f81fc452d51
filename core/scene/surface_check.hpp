#pragma once

#include <string>
#include <vector>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// A surface that bounds a volume: every edge has two triangles that run through it in opposite directions, no two
/// triangles meet but at the vertices and edges that they share, none is flat, all are counter-clockwise seen from the
/// material. Shells inside others are cavities (and bodies within these).
struct CheckedSurface {
  TriangleSurface surface;
  std::vector<std::string> notes;  ///< what was repaired or is worth knowing, one sentence each
};

/// Repairs what leaves the surface in space as it is, and says so in a note: vertices that no triangle uses, vertices
/// that equal another exactly, triangles with a repeated vertex or without area, a surface inside out. Anything else is
/// refused: the first of
///   coordinates that are not finite or too large, the same triangle twice, edges of three or more triangles, open
///   edges (and whether they are slits between vertices that are nearly equal), neighbours of opposite orientation,
///   intersections, no volume, a shell in another of the same orientation.
/// Orientations are not made to agree: where they do not, the file was put together wrong, and a guess which half is
/// right would pass for its meaning.
///
/// Throws SceneError "NAME: surface: found ..., allowed ...", with how many, and number (counted from 0 as in
/// `surface`) and coordinates of the first. `name` is the file's.
CheckedSurface check_surface(TriangleSurface surface, const std::string& name);

}  // namespace finegauge
