#pragma once

#include <Eigen/Core>
#include <array>

#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// Closed surfaces whose solids are known exactly, triangles counter-clockwise seen from outside, each vertex once.

/// 20 divisions² triangles: each face of the icosahedron on an even triangular lattice, all vertices put on the sphere.
/// Not the icosphere of repeated halving: there edges are halved on the sphere, here in the plane of the face.
TriangleSurface icosphere(int divisions, double radius = 1.0, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero());
/// The icosphere stretched to the half axes along x, y, z [m].
TriangleSurface closed_ellipsoid(int divisions, const Eigen::Vector3d& half_axes,
                                 const Eigen::Vector3d& centre = Eigen::Vector3d::Zero());
/// A box of edge lengths `size` [m], each face split into divisions² squares of two triangles, turned about its centre.
/// With turn the identity its faces lie in planes of constant x, y, z exactly.
TriangleSurface closed_box(const Eigen::Vector3d& size, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero(),
                           const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity(), int divisions = 1);
/// A tube of radius tube_radius around a ring of radius ring_radius in the plane z = centre z; 2 × ring × tube
/// triangles.
TriangleSurface closed_torus(double ring_radius, double tube_radius, int ring_divisions, int tube_divisions,
                             const Eigen::Vector3d& centre = Eigen::Vector3d::Zero());
/// Four corners in any order that spans a volume.
TriangleSurface closed_tetrahedron(const std::array<Eigen::Vector3d, 4>& corners);

/// Every vertex carried to A X + b; turned back inside in when A mirrors.
TriangleSurface affine_image(const Eigen::Matrix3d& A, const Eigen::Vector3d& b, TriangleSurface surface);
/// The same surface seen from inside.
TriangleSurface turned_inside_out(TriangleSurface surface);
/// How often the surface winds around X, from the solid angles of its triangles (Van Oosterom & Strackee 1983): 1
/// inside, 0 outside, to round-off unless X lies on the surface.
double winding_number(const TriangleSurface& surface, const Eigen::Vector3d& X);
/// Turn by 30° about an axis that is oblique to all coordinate axes and planes: (1, 2, 3).
Eigen::Matrix3d oblique_turn();

}  // namespace finegauge
