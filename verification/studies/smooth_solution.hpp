#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/elasticity/material.hpp"
#include "core/mesh/refinement_template.hpp"
#include "verification/support/convergence.hpp"
#include "verification/support/manufactured_solution.hpp"

namespace finegauge {

/// Grids of the unit cube, n cells along each edge, on which a manufactured solution is prescribed all around.
struct SmoothCase {
  ManufacturedSolution exact = smooth_solution();
  Material material;                         ///< E = 1e3, nu = 0.3
  double perturbation = 0.0;                 ///< nodes are moved by up to this share of the cell size along each axis
  std::uint32_t seed = 1;                    ///< of the perturbation
  std::optional<RefinementTemplate> octant;  ///< refines the cells in [0, 1/2]³
  int body_points_per_axis = 3;              ///< Gauss points of the body force, see nodal_loads
};

/// What one grid gave. Errors are relative to the norm of the exact solution.
struct SmoothRow {
  int n = 0;  ///< base cells along an edge
  int cells = 0, nodes = 0, hanging_nodes = 0, dofs = 0;
  double displacement_error = 0.0;  ///< L2
  double nodal_error = 0.0;         ///< root of the sum of squares over the nodes inside the body
  double energy_error = 0.0;
  double recovered_stress_error = 0.0;  ///< energy norm of the recovered stress's error
  double effectivity = 0.0;             ///< estimated over true error of the energy norm
  double cell_effectivity_p5 = 0.0, cell_effectivity_p50 = 0.0, cell_effectivity_p95 = 0.0;
};

/// Solves the case on one grid. Errors are integrated with points_per_axis³ Gauss points in each leaf. Throws
/// std::runtime_error when the solve fails: without a solution there is no row.
SmoothRow solve_smooth_case(const SmoothCase& the_case, int n, int points_per_axis = 4);

struct SmoothTable {
  std::string name;  ///< problem, Poisson ratio, dilatation and mesh in words
  SmoothCase the_case;
  std::vector<SmoothRow> rows;  ///< coarsest grid first

  ErrorSeries displacement() const, nodal() const, energy() const, recovered_stress() const;
  /// Errors and orders by grids.
  std::string text() const;
};
SmoothTable smooth_table(const SmoothCase& the_case, const std::vector<int>& grids = {4, 8, 16});

/// Every case that the tests gate: regular, perturbed and partly refined meshes at nu = 0.3, and both dilatations near
/// incompressibility.
std::vector<SmoothCase> smooth_solution_cases();

}  // namespace finegauge
