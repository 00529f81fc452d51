#pragma once

#include <filesystem>

#include "core/mesh/base_mesh.hpp"

namespace finegauge {

/// A mesh from a gmsh file, ASCII, format 2.2 or 4.1: first-order hexahedra (element type 5) or tetrahedra (type 4),
/// and a surface for every physical group of quadrangles (3) or triangles (2), by its name or else
/// `physical_<number>`. Points and lines are skipped, as are nodes that belong to no cell and sections of other data.
///
/// Throws SceneError "FILE:LINE: ..." for binary files, other formats, second-order elements, prisms, pyramids, a mix
/// of shapes, missing or cut sections, counts that do not hold, unknown or repeated tags, inverted or flat cells
/// (named by their tag), a physical face that is not on the boundary, and files above 1 GiB.
BaseMesh read_gmsh(const std::filesystem::path& file);

}  // namespace finegauge
