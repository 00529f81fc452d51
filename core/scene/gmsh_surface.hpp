#pragma once

#include <string>
#include <string_view>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// All first-order triangles of a gmsh file (ASCII, format 2.2 or 4.1) and all nodes; cells, lines and points are
/// skipped, quadrangles are refused. gmsh orients the triangles of each geometrical entity as that entity, not as a
/// closed surface, so that orientations are made to agree from neighbour to neighbour, as the first triangle of each
/// piece has it. `file` is for messages: throws SceneError "FILE:LINE: ...".
TriangleSurface read_gmsh_surface(const std::string& file, std::string_view text);

}  // namespace finegauge
