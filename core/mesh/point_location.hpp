#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

/// A point of the body by base cell and natural coordinates there: it stays the same point whatever is refined or
/// coarsened, and however the body deforms.
struct MaterialPoint {
  int base_cell = -1;
  Eigen::Vector3d xi = Eigen::Vector3d::Zero();
};
/// A point by leaf of a mesh and natural coordinates in the leaf.
struct LeafPoint {
  int cell = -1;
  Eigen::Vector3d xi = Eigen::Vector3d::Zero();
};

/// How far outside of a cell a point still counts as on its surface, in natural coordinates; it is then moved onto the
/// cell. Beside it stands the round-off of the positions, which decides in cells below a ten-millionth of the body.
inline constexpr double location_slack = 1e-9;

Eigen::Vector3d rest_position(const BaseMesh& base, const MaterialPoint& point);
/// The leaf that contains the point; on a face, edge or node between leaves, any of them (a conforming field is the
/// same in all), always the same one. `mesh` is `forest.leaf_mesh()` of the forest as it is now. Costs the depth of the
/// leaf times the logarithm of the number of cells.
LeafPoint find_leaf(const RefinementForest& forest, const Mesh& mesh, const MaterialPoint& point);
MaterialPoint material_point(const Mesh& mesh, const LeafPoint& point);
/// Value of a nodal field (3 × n_nodes) there.
Eigen::Vector3d interpolate(const Mesh& mesh, const Eigen::Matrix3Xd& nodal, const LeafPoint& point);

/// The point of the body that is at X at rest [m]; none if X is outside by more than `location_slack`. Where base cells
/// share it, the hint if it is one of them, else the first. `hint`: a base cell to try first.
std::optional<MaterialPoint> locate_at_rest(const BaseMesh& base, const Eigen::Vector3d& X, int hint = -1);
/// The point of the body that the displacement u (3 × n_nodes) has carried to x; `hint`: a leaf to try first. Right on
/// faces, edges and nodes, and for any conforming deformation that inverts no cell. Where the deformed body overlaps
/// itself the hint's answer is taken, else that of the first leaf.
/// A pass over all leaves when the hint does not contain x, without allocation: one axis, then the box along the cell's
/// own axes, then Newton's method on its map.
std::optional<MaterialPoint> locate_deformed(const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::Vector3d& x,
                                             int hint = -1);

/// Where a segment enters the deformed body: the first crossing of a boundary face from outside to inside.
struct SurfaceHit {
  MaterialPoint point;       ///< on the surface
  Eigen::Vector3d position;  ///< current [m]
  Eigen::Vector3d inward;    ///< unit normal of the current face, into the body; of one of them on a kink
  double fraction;           ///< of the segment, 0 to 1
};
/// Faces are bilinear patches (triangles for tetrahedra) that belong to the body with their edges, so no segment slips
/// through between two of them; a hit may lie `location_slack` of a face beyond either end of the segment, so that none
/// is lost between two segments in a row. A face seen edge-on is no entry, nor is a way out. A segment that grazes a
/// convex edge may be reported.
std::optional<SurfaceHit> first_entry(const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::Vector3d& from,
                                      const Eigen::Vector3d& to);
/// The point of the deformed surface nearest to x (`fraction` zero), searched among the faces within `reach` of x [m];
/// the first face in mesh order among equals.
std::optional<SurfaceHit> nearest_surface_point(const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::Vector3d& x,
                                                double reach);

}  // namespace finegauge
