#pragma once

#include "core/elasticity/material.hpp"
#include "verification/support/evidence.hpp"

namespace finegauge {

/// Plane problems with published targets, solved with one or two layers of hexahedra. Plane stress: the body is the
/// half above its mid-plane, which keeps its height, and its upper face is free. Across so thin a body u_z is linear in
/// z, which a trilinear cell has: it finds the thickness's own strain, continuous from cell to cell. Plane strain: both
/// faces keep their height.

/// Cook's membrane: (0,0) (48,44) (48,60) (0,44), E = 1, nu = 1/3, plane stress, x = 0 held in its plane, a unit shear
/// force per thickness spread over x = 48. Lines of the mesh gather, quadratically, at all edges: at (0, 44) and
/// (0, 0) the stress is singular, at (48, 60) and (48, 44) the sheared edge meets a free one.
struct CookRow {
  int n = 0;  ///< cells along each edge
  int dofs = 0;
  double middle = 0.0, corner = 0.0;  ///< u_y at (48, 52) and at (48, 60)
  double thickness_stress = 0.0;      ///< root of the mean of σ_zz² over that of σ_xx² at the cells' centres
};
CookRow solve_cook(int n, Dilatation dilatation);

/// NAFEMS LE1, elliptic membrane (The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990): a quarter of the plate between
/// (x/2)² + y² = 1 and (x/3.25)² + (y/2.75)² = 1 [m], E = 210 GPa, nu = 0.3, 10 MPa outward on the outer
/// edge. n cells across, 2 n along the ellipses, two layers, 0.01 m thick so that the stress is plane.
///
/// The strain across the thickness is continuous from cell to cell, that in the plane is not: the one follows the other
/// in the mean of a node's cells, which at a free edge lie on one side only. So σ_zz vanishes with first order there,
/// and takes nu / (1 - nu) of itself along into σ_yy.
struct MembraneRow {
  int n = 0;
  int dofs = 0;
  double stress = 0.0;            ///< σ_yy at D = (2, 0), recovered [Pa]
  double thickness_stress = 0.0;  ///< σ_zz there, which plane stress has not
  double plane_stress = 0.0;      ///< σ_yy - nu / (1 - nu) σ_zz: what the strains in the plane alone make of it
};
MembraneRow solve_elliptic_membrane(int n, Dilatation dilatation);

/// Kirsch's hole of radius 1 m in an infinite plate under a tension of 1 Pa along x: the ring up to radius 4 m, plane
/// strain, its outer edge moved as the infinite plate's solution moves it. n cells along and across a quarter, square
/// in the logarithm of the radius.
struct KirschRow {
  int n = 0;
  int dofs = 0;
  double displacement_error = 0.0;             ///< root of the mean square over the nodes, relative
  double top_stress = 0.0, side_stress = 0.0;  ///< hoop stress on the hole at 90 and at 0 degrees, recovered [Pa]
};
KirschRow solve_kirsch(int n, Dilatation dilatation);

Evidence plane_problems_evidence(const EvidenceOptions& options);

}  // namespace finegauge
