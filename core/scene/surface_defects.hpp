#pragma once

#include <string>
#include <vector>

#include "core/mesh/triangle_surface.hpp"
#include "core/scene/surface_edges.hpp"

namespace finegauge {

/// Each looks for one defect and says in words that complete "NAME: surface: " what was found, where, and what is
/// allowed; empty when there is none. `numbers`: of the triangles, as the user counts them.

/// Vertices that are not finite, or so large or small together that products of three lengths are not.
std::string coordinate_defect(const TriangleSurface& surface);
std::string duplicate_defect(const TriangleSurface& surface, const std::vector<int>& numbers);
/// Edges of one or of three and more triangles, and neighbours that run through their edge in the same direction.
std::string edge_defect(const TriangleSurface& surface, const std::vector<SurfaceEdge>& edges,
                        const std::vector<int>& numbers);

/// "(0.1, 0.2, 0.3)"
std::string point_words(const Eigen::Vector3d& point);
/// "3 open edges", "1 open edge"
std::string counted(std::size_t count, const std::string& one, const std::string& many);

}  // namespace finegauge
