#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/point_location.hpp"
#include "core/mesh/region.hpp"

namespace finegauge {

/// A piece of the body's surface at rest: a triangle of an immersed body's surface, or a boundary face of the mesh.
struct SurfaceFacet {
  int corner_count;                        ///< 3, or 4: at (0,0), (1,0), (0,1), (1,1) of a bilinear patch
  std::array<Eigen::Vector3d, 4> corners;  ///< [m]
  BaseFace face = {-1, -1};                ///< of a mesh without immersed body
};
/// All of them: the triangles in the order of the surface, or the boundary faces, ascending.
std::vector<SurfaceFacet> surface_facets(const BaseMesh& base);

/// Numbers of the facets whose centre, the mean of their corners, is selected. The nearest point of a patch is found on
/// the facets; a quadrilateral counts there as two triangles.
Selected select_facets(const std::vector<SurfaceFacet>& facets, const Selection& selection);

/// A quadrature point of the surface.
struct SurfacePoint {
  MaterialPoint at;
  double area;  ///< share of the selected rest area [m²], > 0
};
/// Quadrature of the facets: triangles by the three-point rule (exact for quadratics; Strang & Fix 1973), those of an
/// immersed surface cut into parts of at most half a cell each way; quadrilaterals by 2×2 Gauss points. Facets without
/// area are left out. A point of an immersed surface whose lattice cell is no base cell, having next to no material,
/// belongs to the nearest base cell, moved onto it.
std::vector<SurfacePoint> surface_points(const BaseMesh& base, const std::vector<SurfaceFacet>& facets,
                                         const std::vector<int>& numbers);

/// The base cells that the triangles touch, ascending. Of an immersed body.
std::vector<int> touched_cells(const BaseMesh& base, const std::vector<SurfaceFacet>& facets,
                               const std::vector<int>& numbers);

}  // namespace finegauge
