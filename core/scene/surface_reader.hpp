#pragma once

#include <filesystem>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// The triangles of a surface file as they stand in it, coordinates unchanged: STL (text, binary), OBJ, PLY (text,
/// binary of either byte order) or gmsh (ASCII, 2.2 and 4.1). Told by content; OBJ, which has no mark, by its
/// extension. Whether they are a closed surface is for check_surface. Throws SceneError "FILE:LINE: ..." or "FILE: byte
/// N: ..." with what was found and what is allowed; files above 256 MiB are refused unread, and so are
/// surfaces of more than 10 million triangles.
///
/// Own readers because of the messages: those of CGAL and of assimp name neither place nor value, and either repairs
/// silently (joins, drops) what a user has to know of.
TriangleSurface read_surface(const std::filesystem::path& file);

}  // namespace finegauge
