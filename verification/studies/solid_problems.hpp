#pragma once

#include <string>
#include <vector>

#include "core/elasticity/material.hpp"
#include "verification/support/evidence.hpp"

namespace finegauge {

/// Solids with closed forms or published targets, hexahedra.

/// A thick wall under a pressure of 1 Pa inside, E = 1 kPa, by a wedge between planes of symmetry: MacNeal & Harder's
/// cylinder of radii 3 m and 9 m in plane strain (30 degrees, two layers), or the sphere of radii 1 m and 2 m (the
/// sixth of an octant that a face of the cube looks at). Cells near square in the logarithm of the radius; inclined
/// planes of symmetry are held along their normals.
enum class Wall { cylinder, sphere };
struct WallRow {
  Wall wall;
  double poisson_ratio = 0.0;
  Dilatation dilatation = Dilatation::standard;
  int n = 0;  ///< cells through the wall
  int dofs = 0;
  double inner_displacement = 0.0;  ///< radial, mean over the inner face's nodes [m]
  double exact_displacement = 0.0;
  double displacement_error = 0.0;  ///< root of the mean square over all nodes, relative
  double hoop_stress = 0.0;         ///< recovered, mean over the inner face's nodes [Pa]
  double exact_hoop_stress = 0.0;

  /// Exact over found displacement, minus one: stiffness that is not the body's, as a share of the body's own.
  double excess_stiffness() const { return exact_displacement / inner_displacement - 1.0; }
};
WallRow solve_thick_wall(Wall wall, double poisson_ratio, Dilatation dilatation, int n);

/// NAFEMS LE10, thick plate (The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990): LE1's quarter of an elliptic ring,
/// 0.6 m thick, 1 MPa down on its upper face, the outer edge held in the plane and at mid-height. n cells through the
/// thickness, n across, 3 n / 2 along the ellipses.
struct PlateRow {
  int n = 0;
  int dofs = 0;
  double stress = 0.0;  ///< σ_yy at D = (2, 0, 0.6), recovered [Pa]
};
PlateRow solve_thick_plate(int n, Dilatation dilatation);

/// Boussinesq's point load of 0.1 N on the half-space, E = 1e4 Pa, nu = 0.4: a quarter of the cube of 80 mm × 80 mm ×
/// 40 mm below it, its far faces moved as the half-space's solution moves them. Cells are halved towards the load by
/// the forest, over hanging nodes, and once more everywhere from row to row.
struct HalfSpaceRow {
  int level = 0;
  int cells = 0, hanging_nodes = 0, dofs = 0;
  double smallest = 0.0;            ///< cell at the load [m]
  double settlement = 0.0;          ///< u_z on the surface, 10 mm from the load [m]
  double displacement_error = 0.0;  ///< root of the mean square, nodes of the first row's mesh from 10 mm on, relative
  double axial_stress = 0.0;        ///< σ_zz 10 mm below the load, recovered [Pa]
};
std::vector<HalfSpaceRow> half_space_table(int levels, Dilatation dilatation);
double half_space_settlement();    ///< P (1 - nu²) / (π E r) [m]
double half_space_axial_stress();  ///< -3 P / (2 π z²) [Pa]

Evidence solid_problems_evidence(const EvidenceOptions& options);

}  // namespace finegauge
