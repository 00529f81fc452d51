#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/elasticity/material.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/convergence.hpp"
#include "verification/support/evidence.hpp"
#include "verification/support/manufactured_solution.hpp"

namespace finegauge {

/// A mesh of the unit cube, to be had with any number n of cells along an edge; tetrahedral ones split each in six.
struct CubeMesh {
  CellShape shape = CellShape::hexahedron;
  double perturbation = 0.0;  ///< inner nodes are moved by up to this share of 1/n along each axis
  std::uint32_t seed = 1;     ///< of the perturbation
  /// Entry l refines the leaves that lie in [0, 2^-(l+1)]³, by its templates in turn: neighbours get different ones.
  std::vector<std::vector<RefinementTemplate>> levels = {};
};
RefinementForest refined_cube(const CubeMesh& mesh, int n);

/// A field as a formula in jets.
using FieldFormula = std::function<Jets(const Jets& x)>;
/// The field at the nodes, made conforming: nodes that hang have their masters' interpolation.
Eigen::Matrix3Xd interpolant(const Discretization& d, const FieldFormula& exact);

/// Errors of a nodal field against a formula, for both cell shapes.
struct FormulaErrors {
  double displacement = 0.0, displacement_norm = 0.0;  ///< sqrt ∫ |u_h - u|², sqrt ∫ |u|² [m^2.5]
  double best_displacement = 0.0;  ///< the same of each cell's own best fit to u: no conforming field has less
  double gradient = 0.0, gradient_norm = 0.0;  ///< sqrt ∫ |∇(u_h - u)|², sqrt ∫ |∇u|² [m^1.5]
  double energy = 0.0, energy_norm = 0.0;  ///< sqrt ∫ (σ_h - σ):C⁻¹:(σ_h - σ), sqrt ∫ σ:C⁻¹:σ [√J]; zero unless
                                           ///< the kinematics are linear
};
/// With 3 × 3 × 3 Gauss points in a hexahedron, exact for degree 5 along each axis, and the 15 points of degree 5 of
/// Grundmann & Möller (1978) in a tetrahedron: the square of an error of second degree has degree 4.
FormulaErrors formula_errors(const Discretization& d, const FieldFormula& exact, const Eigen::Matrix3Xd& u);

/// Points and weights of the tetrahedron's rule; natural coordinates, weights sum to 1/6.
struct TetrahedronPoint {
  Eigen::Vector3d xi;
  double weight;
};
std::vector<TetrahedronPoint> tetrahedron_rule();

/// First term in the cell sizes of the energy error on hexahedra that are boxes along the axes [√J], see the
/// implementation: from second derivatives of the solution alone, without any finite element.
double leading_energy_error(const Mesh& mesh, const Material& material, const FieldFormula& exact);

struct StaticCase {
  std::string name;  ///< words joined by underscores
  ManufacturedSolution exact = smooth_solution();
  Material material;  ///< E = 1e3, nu = 0.3
  CubeMesh mesh;
  std::vector<int> grids = {4, 8, 16};
};

/// What one grid gave. Errors are relative to the norm of the exact solution.
struct StaticRow {
  int n = 0;  ///< cells along an edge before refinement
  int cells = 0, hanging_nodes = 0, dofs = 0;
  double displacement_error = 0.0;  ///< L2
  double nodal_error = 0.0;         ///< root of the sum of squares over the nodes inside the body
  double energy_error = 0.0;
  double displacement_over_best = 0.0;   ///< over FormulaErrors::best_displacement
  double energy_over_interpolant = 0.0;  ///< zero with the mean dilatation, which minimizes no energy error
  double energy_over_leading = 0.0;      ///< over leading_energy_error; zero where cells are no boxes
};
/// The boundary is held all around where the solution has it. Throws std::runtime_error when the solve fails: without a
/// solution there is no row.
StaticRow solve_static_case(const StaticCase& the_case, int n);

struct StaticTable {
  StaticCase the_case;
  std::vector<StaticRow> rows;  ///< coarsest grid first

  ErrorSeries displacement() const, nodal() const, energy() const;
};
StaticTable static_table(const StaticCase& the_case);

/// Regular, perturbed, partly refined, nested and mixed hexahedra, and tetrahedra, at nu = 0.3; with `full` finer
/// grids, and the 19 templates that differ by more than a turn.
std::vector<StaticCase> static_cases(bool full);
/// The isochoric field at nu = 0.4, 0.499 and 0.4999 with both dilatations, and at 0.4999 in perturbed cells.
std::vector<StaticCase> near_incompressible_cases(bool full);

Evidence manufactured_static_evidence(const EvidenceOptions& options);

}  // namespace finegauge
