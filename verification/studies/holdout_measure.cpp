#include <cmath>
#include <stdexcept>

#include "core/adapt/apply_refinements.hpp"
#include "core/adapt/marking.hpp"
#include "core/equilibrated_estimate.hpp"
#include "verification/studies/holdout.hpp"
#include "verification/support/tetrahedra_of.hpp"

namespace finegauge {

namespace {

/// Beyond these the equilibrated estimate takes longer than all the rest, and refinement goes on to no purpose.
constexpr int most_cells_of_equilibrated = 2000, most_dofs_refined = 12000;
/// Hexahedra of a base mesh that without `all_meshes` is split into tetrahedra as well.
constexpr std::size_t most_cells_split_in_short = 400;

StaticSolution solved_problem(const RefinementForest& forest, const StaticProblem& problem) {
  FactorCache factors;
  StaticSolution solution = solve_static(forest, problem, nullptr, factors);
  if (!solution.equilibrium.converged) throw std::runtime_error("holdout: a solve did not converge");
  return solution;
}

void refine_by_estimate(RefinementForest& forest, const StaticSolution& solution, double theta) {
  const Eigen::VectorXd& eta = solution.estimate.eta;
  std::vector<Refinement> refinements;
  for (const int cell : mark_maximum({eta.data(), static_cast<std::size_t>(eta.size())}, theta))
    refinements.push_back({cell, {}});
  apply_refinements(forest, solution.discretization.mesh, refinements);
}

/// ∫ ε:σ - 2 F·u [J].
double twice_potential(const RefinementForest& forest, const StaticProblem& problem, const StaticSolution& solution) {
  const Eigen::Matrix3Xd forces = nodal_loads(forest.base(), solution.discretization.mesh, problem.loads, problem.body);
  return std::pow(solution.estimate.energy_norm, 2) - 2.0 * forces.cwiseProduct(solution.equilibrium.u).sum();
}

double equilibrated_total(const RefinementForest& forest, const StaticProblem& problem, const StaticSolution& solution,
                          const ErrorEstimate& spr) {
  const EquilibratedEstimate estimate =
      estimate_error_equilibrated(forest, solution.discretization, problem, solution.equilibrium.u, spr);
  if (!estimate.exists()) throw std::runtime_error("holdout: " + estimate.why_not);
  return estimate.total;
}

/// All cells halved, then by the estimate wherever it is above a quarter of its largest.
ReferenceEnergy reference_energy(const BaseMesh& mesh, const StaticProblem& problem, int dofs) {
  RefinementForest forest(mesh);
  refine_uniformly(forest);
  StaticSolution solution = solved_problem(forest, problem);
  while (solution.discretization.dof_count() < dofs) {
    refine_by_estimate(forest, solution, 0.25);
    solution = solved_problem(forest, problem);
  }
  const ErrorEstimate spr = estimate_error(solution.discretization, solution.equilibrium.u, Estimator::spr);
  const double most = std::pow(equilibrated_total(forest, problem, solution, spr), 2);
  return {twice_potential(forest, problem, solution), 0.25 * most, most, solution.discretization.dof_count()};
}

/// A mesh's estimates [√J], and what its truth takes.
struct Estimated {
  HoldoutRow row;
  double energy_norm, twice_potential;
  double true_error = 0.0;  ///< [√J], of an exact field
};

Estimated estimated(const std::string& name, const RefinementForest& forest, const HoldoutProblem& problem,
                    const StaticProblem& statics, const StaticSolution& solution) {
  const Discretization& d = solution.discretization;
  const Eigen::Matrix3Xd& u = solution.equilibrium.u;
  const ErrorEstimate spr = estimate_error(d, u, Estimator::spr);
  Estimated result{{name, d.mesh.shape, d.mesh.cell_count(), d.dof_count()},
                   spr.energy_norm,
                   twice_potential(forest, statics, solution)};
  result.row.spr = spr.total, result.row.spr_edges = solution.estimate.total;
  if (d.mesh.shape == CellShape::hexahedron && d.mesh.cell_count() <= most_cells_of_equilibrated)
    result.row.equilibrated = equilibrated_total(forest, statics, solution, spr);
  if (problem.exact.stress) result.true_error = true_error(d, problem.exact, u, spr.nodal_stress).total;
  return result;
}

/// The square of the truth lies between that of the least and of the most error of the reference, added.
HoldoutRow finished(const Estimated& mesh, double least, double most) {
  HoldoutRow row = mesh.row;
  const double truth = 0.5 * (least + most);
  row.true_error = truth / mesh.energy_norm;
  row.uncertainty = 0.5 * (most - least) / truth;
  for (double* estimate : {&row.spr, &row.spr_edges, &row.equilibrated}) *estimate /= truth;
  return row;
}

/// Of a base mesh and those that follow from it.
void add_estimated(const BaseMesh& base, const std::string& prefix, const HoldoutProblem& problem,
                   const StaticProblem& statics, bool all_meshes, std::vector<Estimated>& meshes) {
  RefinementForest forest(base);
  StaticSolution solution = solved_problem(forest, statics);
  meshes.push_back(estimated(prefix + "base", forest, problem, statics, solution));
  for (int step = 1; step <= (all_meshes ? 4 : 1); ++step) {
    if (solution.discretization.dof_count() > most_dofs_refined) break;
    refine_by_estimate(forest, solution, 0.5);
    solution = solved_problem(forest, statics);
    if (step != 3)
      meshes.push_back(estimated(prefix + "refined " + std::to_string(step) + "x", forest, problem, statics, solution));
  }
  if (!all_meshes) return;
  RefinementForest halved(base);
  refine_uniformly(halved);
  meshes.push_back(estimated(prefix + "halved", halved, problem, statics, solved_problem(halved, statics)));
}

}  // namespace

bool is_for_tetrahedra(const HoldoutProblem& problem) {
  const Material& material = problem.problem.material;
  return material.dilatation == Dilatation::standard && material.poisson_ratio <= 0.35 &&
         (problem.weakness.empty() || problem.refused == refused_cells) && problem.refused != refused_load &&
         problem.refused != refused_between;
}

std::vector<HoldoutRow> measure(const HoldoutProblem& problem, const HoldoutOptions& options) {
  StaticProblem statics = problem.problem;
  statics.solver.linear.relative_residual = 1e-8;
  statics.estimator = Estimator::spr_edges;
  std::vector<Estimated> meshes;
  add_estimated(problem.mesh, "", problem, statics, options.all_meshes, meshes);
  if (is_for_tetrahedra(problem) && (options.all_meshes || problem.mesh.cells.size() <= most_cells_split_in_short))
    add_estimated(tetrahedra_of(problem.mesh), "tetrahedra, ", problem, statics, options.all_meshes, meshes);
  std::vector<HoldoutRow> rows;
  if (problem.exact.stress) {
    for (const Estimated& mesh : meshes) rows.push_back(finished(mesh, mesh.true_error, mesh.true_error));
    return rows;
  }
  const ReferenceEnergy reference = reference_energy(problem.mesh, statics, options.reference_dofs);
  for (const Estimated& mesh : meshes) {
    const double squared = std::max(0.0, mesh.twice_potential - reference.twice_potential);
    rows.push_back(finished(mesh, std::sqrt(squared + reference.least_error_squared),
                            std::sqrt(squared + reference.most_error_squared)));
  }
  return rows;
}

}  // namespace finegauge
