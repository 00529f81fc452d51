#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.hpp"
#include "core/mesh/point_location.hpp"
#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// A plane that a body is cut by. Its picture has x to the right along up × normal and y along up, seen from the side
/// that the normal points to.
struct SectionPlane {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();      ///< unit, in the plane

  Eigen::Vector2d operator()(const Eigen::Vector3d& x) const;  ///< its place in the picture [m]
};
/// The plane that contains a line and, as nearly as may be, the direction up; the line's direction is drawn from left
/// to right. A line along up has no such plane: then any that contains it.
SectionPlane plane_along(const Eigen::Vector3d& point, const Eigen::Vector3d& direction, const Eigen::Vector3d& up);

// Nodes in the plane itself, as a needle on a line of nodes has them, would be to either side as round-off decides, and
// faces there belong to none or two cells. So what is cut is a plane that lies this share of the body's diagonal
// farther along the normal: too little to be seen, and more than round-off.
inline constexpr double section_offset = 1e-6;

struct CellSection {
  int cell;
  std::vector<Eigen::Vector2d> polygon;  ///< in the plane [m], closed
};
/// What the plane cuts of the deformed cells, ascending by cell; a strongly distorted hexahedron may have two polygons.
/// Exact where cells have plane faces, else with straight lines across the faces, the same in both cells of a face: the
/// sections fill the body's without gap or overlap, but for the warp of faces with hanging nodes. `positions`: current,
/// 3 × n_nodes.
std::vector<CellSection> section_of_cells(const Mesh& mesh, const Eigen::Matrix3Xd& positions,
                                          const SectionPlane& plane);

/// What the plane cuts of a closed surface: closed polygons in the plane [m], in the order of their first triangles.
/// Chains that do not close, of a surface that does not, are left out.
std::vector<std::vector<Eigen::Vector2d>> section_of_surface(const TriangleSurface& surface, const SectionPlane& plane);

/// Twice the area to the left of a closed polygon, its sign included [m²].
double signed_double_area(const std::vector<Eigen::Vector2d>& polygon);

/// The points of the body at the surface's vertices. A vertex that sticks out of the base cells, as the tip of a thorn
/// does where the cell around it holds too little to exist, goes with the nearest point of them. Throws
/// std::invalid_argument where that is farther than a base cell is long.
std::vector<MaterialPoint> points_of_surface(const BaseMesh& base, const TriangleSurface& surface);
/// The surface at rest carried by the displacement u (3 × n_nodes) of a mesh of the forest.
TriangleSurface carried_surface(const TriangleSurface& surface, const std::vector<MaterialPoint>& points,
                                const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& u);

}  // namespace finegauge
