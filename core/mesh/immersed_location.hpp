#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/mesh/point_location.hpp"

namespace finegauge {

/// first_entry and nearest_surface_point (point_location.hpp) for the surface of an immersed body: `base.body` is
/// there, `mesh` is a leaf mesh of a forest on `base`.
///
/// The displacement carries every point of the rest surface: a triangle is cut by the leaves that it crosses, and each
/// piece is curved as the map of its leaf is. So the surface is the border of what locate_in_body (body_location.hpp)
/// calls inside, it follows the dimple under a needle however large the triangles are, and it has no gaps where leaves
/// of unlike sizes meet: flat triangles between carried corners would do neither. Where the surface runs through no
/// base cell (what the mesh left out as too little material) it has no pieces. Each is a pass over the leaves of cells
/// that the surface runs through; what lies away from the segment costs a bounding box.
///
/// The entry is the first of all that a piece has (immersed_entry.cpp). In a cell that is not all but flat none is
/// missed at which the sine of the angle between segment and surface is above two millionths. A flatter one can be. A
/// segment that goes in and comes out again where the surface bends away is then inside by less than 2e-12 of the
/// radius of curvature along it; but one that runs along a straight line in the surface (an edge of a bent cell) and
/// goes in at such an angle may be deep inside farther on. What grazes a bent piece costs some tens of microseconds
/// more than what crosses it, what runs along a straight line in it a millisecond and more.
///
/// The nearest point is sought by Newton's method in each piece, from its middle and halfway to its corners, and along
/// its border; a piece bent so far within one leaf that none of these leads there is one whose cell is all but
/// inverted.
std::optional<SurfaceHit> first_immersed_entry(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                               const Eigen::Vector3d& from, const Eigen::Vector3d& to);
std::optional<SurfaceHit> nearest_immersed_surface_point(const BaseMesh& base, const Mesh& mesh,
                                                         const Eigen::Matrix3Xd& u, const Eigen::Vector3d& x,
                                                         double reach);

}  // namespace finegauge
