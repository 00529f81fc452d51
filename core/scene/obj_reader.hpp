#pragma once

#include <string>
#include <string_view>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// The vertices (v) and faces (f) of a Wavefront OBJ file; corners may be written a, a/b, a//c and a/b/c and count from
/// the end where they are negative. Faces of more than three corners are cut as a fan from their first, which is right
/// for convex ones. Groups, objects, materials, normals, texture, points and lines are skipped; free-form geometry and
/// unknown words are refused. `file` is for messages: throws SceneError "FILE:LINE: ...".
TriangleSurface read_obj(const std::string& file, std::string_view text);

}  // namespace finegauge
