#pragma once

#include <string>
#include <string_view>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// The vertices (element vertex: x, y, z of any type) and faces (element face: a list named vertex_indices or
/// vertex_index) of a PLY file, version 1.0, text or binary of either byte order. Faces of more than three corners are
/// cut as a fan from their first; other properties and elements are skipped. Counts that the rest of the file could not
/// hold are refused before anything is stored. `file` is for messages: throws SceneError "FILE:LINE: ..." for the
/// header and for text, "FILE: byte N: ..." for binary data.
TriangleSurface read_ply(const std::string& file, std::string_view bytes);

}  // namespace finegauge
