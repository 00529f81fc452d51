#include "verification/studies/smooth_solution.hpp"

#include <algorithm>
#include <iomanip>
#include <random>
#include <sstream>
#include <stdexcept>

#include "core/adapt/error_estimate.hpp"
#include "core/equilibrium.hpp"
#include "verification/support/field_errors.hpp"
#include "verification/support/percentile.hpp"
#include "verification/support/sample_cells.hpp"

namespace finegauge {

namespace {

/// Nodes on the cube's surface move inside their planes, so that the body stays the cube.
BaseMesh cube(const SmoothCase& the_case, int n) {
  BoxMeshOptions options;
  options.cells = {n, n, n};
  BaseMesh mesh = box_mesh(options);
  std::mt19937 generator(the_case.seed);
  for (Eigen::Index node = 0; node < mesh.nodes.cols(); ++node) {
    const Eigen::Vector3d shift = the_case.perturbation / n * random_vector(generator);
    for (int axis = 0; axis < 3; ++axis) {
      double& x = mesh.nodes(axis, node);
      if (x > 0.0 && x < 1.0) x += shift[axis];
    }
  }
  return mesh;
}

/// Base cells are numbered lexicographically, x fastest, and are the forest's first handles.
void refine_octant(RefinementForest& forest, int n, RefinementTemplate refinement) {
  for (int k = 0; k < n / 2; ++k)
    for (int j = 0; j < n / 2; ++j)
      for (int i = 0; i < n / 2; ++i) forest.refine(i + n * (j + n * k), refinement);
}

ErrorSeries series(const std::string& quantity, const std::vector<SmoothRow>& rows, double SmoothRow::*error) {
  ErrorSeries result{quantity, {}, {}};
  for (const SmoothRow& row : rows) {
    result.h.push_back(1.0 / row.n);
    result.error.push_back(row.*error);
  }
  return result;
}

std::string name_of(const SmoothCase& the_case) {
  std::ostringstream name;
  name << the_case.exact.name << ", nu " << the_case.material.poisson_ratio << ", "
       << (the_case.material.dilatation == Dilatation::mean ? "mean" : "standard") << " dilatation";
  if (the_case.perturbation > 0.0)
    name << ", perturbed by " << the_case.perturbation << " h (seed " << the_case.seed << ")";
  if (the_case.octant) name << ", octant " << to_string(*the_case.octant);
  return name.str();
}

}  // namespace

SmoothRow solve_smooth_case(const SmoothCase& the_case, int n, int points_per_axis) {
  RefinementForest forest(cube(the_case, n));
  if (the_case.octant) refine_octant(forest, n, *the_case.octant);
  const std::vector<SupportCondition> supports = held_all_around(the_case.exact);
  const Discretization d = discretize(forest, the_case.material, supports);
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, supports);
  const auto force = [&](const Eigen::Vector3d& X) { return body_force(the_case.exact, the_case.material, X); };
  const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, {}, force, the_case.body_points_per_axis);
  EquilibriumOptions options;
  options.linear.relative_residual = 1e-9;  // far below the smallest error here, 1e-4
  const Eigen::Matrix3Xd start = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  const Equilibrium solved = solve_equilibrium(d, hierarchy, loads, start, options);
  if (!solved.converged) {
    std::ostringstream message;
    message << name_of(the_case) << ", n = " << n << ": the solve ended at a residual of " << solved.relative_residual;
    throw std::runtime_error(message.str());
  }
  const ErrorEstimate estimate = estimate_error_spr(d, solved.u);
  const FieldErrors errors = field_errors(d, the_case.exact, solved.u, estimate.nodal_stress, points_per_axis);

  SmoothRow row;
  row.n = n;
  row.cells = d.mesh.cell_count();
  row.nodes = d.mesh.node_count();
  row.hanging_nodes = d.hanging.hanging_count();
  row.dofs = d.dof_count();
  row.displacement_error = errors.displacement / errors.displacement_norm;
  row.nodal_error = errors.nodal / errors.nodal_norm;
  row.energy_error = errors.energy / errors.energy_norm;
  row.recovered_stress_error = errors.recovered_stress / errors.energy_norm;
  row.effectivity = estimate.total / errors.energy;
  std::vector<double> by_cell(row.cells);
  for (int cell = 0; cell < row.cells; ++cell) by_cell[cell] = estimate.eta[cell] / errors.cell_energy[cell];
  std::sort(by_cell.begin(), by_cell.end());
  row.cell_effectivity_p5 = percentile(by_cell, 0.05);
  row.cell_effectivity_p50 = percentile(by_cell, 0.50);
  row.cell_effectivity_p95 = percentile(by_cell, 0.95);
  return row;
}

ErrorSeries SmoothTable::displacement() const { return series("L2", rows, &SmoothRow::displacement_error); }
ErrorSeries SmoothTable::nodal() const { return series("nodal", rows, &SmoothRow::nodal_error); }
ErrorSeries SmoothTable::energy() const { return series("energy", rows, &SmoothRow::energy_error); }
ErrorSeries SmoothTable::recovered_stress() const {
  return series("recovered", rows, &SmoothRow::recovered_stress_error);
}

std::string SmoothTable::text() const {
  std::ostringstream text;
  text << name << convergence_table({displacement(), nodal(), energy(), recovered_stress()});
  text << "        n      dofs   hanging  effectivity     p5    p50    p95\n" << std::fixed << std::setprecision(3);
  for (const SmoothRow& row : rows)
    text << std::setw(9) << row.n << std::setw(10) << row.dofs << std::setw(10) << row.hanging_nodes << std::setw(13)
         << row.effectivity << std::setw(7) << row.cell_effectivity_p5 << std::setw(7) << row.cell_effectivity_p50
         << std::setw(7) << row.cell_effectivity_p95 << '\n';
  return text.str();
}

SmoothTable smooth_table(const SmoothCase& the_case, const std::vector<int>& grids) {
  SmoothTable table{name_of(the_case), the_case, {}};
  for (const int n : grids) table.rows.push_back(solve_smooth_case(the_case, n));
  return table;
}

std::vector<SmoothCase> smooth_solution_cases() {
  constexpr double distorted = 0.2;
  std::vector<SmoothCase> cases;
  const auto add = [&](const ManufacturedSolution& exact, double nu, Dilatation dilatation, double perturbation,
                       std::optional<RefinementTemplate> octant) {
    SmoothCase next;
    next.exact = exact;
    next.material.poisson_ratio = nu;
    next.material.dilatation = dilatation;
    next.perturbation = perturbation;
    next.octant = octant;
    cases.push_back(next);
  };
  add(smooth_solution(), 0.3, Dilatation::standard, 0.0, std::nullopt);
  add(smooth_solution(), 0.3, Dilatation::standard, distorted, std::nullopt);
  for (const RefinementTemplate& octant :
       {RefinementTemplate{{2, 2, 2}}, RefinementTemplate{{3, 3, 3}}, RefinementTemplate{{2, 3, 3}},
        RefinementTemplate{{2, 2, 1}}, RefinementTemplate{{4, 1, 2}}})
    add(smooth_solution(), 0.3, Dilatation::standard, 0.0, octant);
  add(smooth_solution(), 0.3, Dilatation::standard, distorted, RefinementTemplate{{2, 2, 2}});
  add(isochoric_solution(), 0.4, Dilatation::standard, 0.0, std::nullopt);
  for (const double perturbation : {0.0, distorted})
    for (const Dilatation dilatation : {Dilatation::standard, Dilatation::mean})
      add(isochoric_solution(), 0.4999, dilatation, perturbation, std::nullopt);
  for (const double perturbation : {0.0, distorted})
    for (const Dilatation dilatation : {Dilatation::standard, Dilatation::mean})
      add(smooth_solution(), 0.4999, dilatation, perturbation, std::nullopt);
  return cases;
}

}  // namespace finegauge
