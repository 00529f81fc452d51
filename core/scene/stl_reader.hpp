#pragma once

#include <string>
#include <string_view>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// Whether these bytes have the length that a binary STL file of as many triangles as they announce must have.
bool is_binary_stl(std::string_view bytes);

/// An STL file of one or more solids, text or binary. It writes the corners of each triangle anew: those that are equal
/// become one vertex, numbered by first appearance. The normals are left unread, orientation is by the order of the
/// corners. `file` is for messages: throws SceneError "FILE:LINE: ..." or "FILE: byte N: ...".
TriangleSurface read_stl(const std::string& file, std::string_view bytes);

}  // namespace finegauge
