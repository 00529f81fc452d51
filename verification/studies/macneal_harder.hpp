#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/elasticity/material.hpp"
#include "verification/support/evidence.hpp"
#include "verification/support/mapped_mesh.hpp"

namespace finegauge {

/// The solid patch test and the beams of MacNeal & Harder, "A proposed standard set of problems to test finite element
/// accuracy", Finite Elements in Analysis and Design 1 (1985) 3-20, with the plain trilinear cell. Units as there:
/// none.

/// The seven cells of the patch under the linear displacement: the largest error of all nodes, of all strains at the
/// quadrature points (every component is 1e-3) and of all stresses there (2000 and 400), each over its largest value.
struct PatchErrors {
  double displacement = 0.0, strain = 0.0, stress = 0.0;
  int free_nodes = 0;
};
PatchErrors solve_macneal_harder_patch(Dilatation dilatation);

/// A unit force over the tip's face, evenly, or a unit moment about the axis through its centre.
struct BeamLoad {
  std::string name;
  Eigen::Vector3d direction;  ///< of the force, or the moment's axis
  bool moment = false;
  double printed = 0.0;  ///< tip displacement along the load as MacNeal & Harder print it
  double theory = 0.0;   ///< the same by closed forms or converged solutions (macneal_harder.cpp says which)
  double hex8 = 0.0;     ///< share of `printed` that a production element with locking cures reaches (OptiStruct)
};

/// A cantilever: the unit cube mapped, clamped at the image of x = 0 and loaded on that of x = 1.
struct Beam {
  std::string name;
  std::array<int, 3> cells;  ///< of the published mesh
  double youngs_modulus, poisson_ratio;
  Eigen::Vector3d tip;  ///< centre of the loaded face
  Mapping position;
  std::vector<BeamLoad> loads;
};

enum class StraightMesh { regular, trapezoidal, parallelogram };
Beam straight_beam(StraightMesh mesh);
Beam curved_beam();
Beam twisted_beam();

/// Displacement of the tip along each load, averaged as the load acts: the work of the unit load, its compliance. Each
/// published cell is divided `divisions` times along its axes. Throws std::runtime_error when the solve fails.
std::vector<double> tip_displacements(const Beam& beam, const std::array<int, 3>& divisions, Dilatation dilatation);

/// The same of the straight regular beam of n cells in a row, from beam theory for the trilinear cell (closed forms in
/// the section, see macneal_harder.cpp): knows no cell, no quadrature in the section and no assembly of bricks.
std::vector<double> one_cell_section_beam(int n, Dilatation dilatation);

/// Share of its curvature that one rectangular bilinear cell under pure bending in plane stress takes, length over
/// height given: the rest is shear that it cannot help (Cook, Malkus, Plesha & Witt 2002, section 6.6).
double bending_share(double slenderness, double poisson_ratio);

/// Torsion constant of a rectangle, Saint-Venant's series.
double torsion_constant(double a, double b);

Evidence macneal_harder_evidence(const EvidenceOptions& options);

}  // namespace finegauge
