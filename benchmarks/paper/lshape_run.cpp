#include "benchmarks/paper/lshape_run.hpp"

#include <optional>
#include <span>

#include "core/adapt/apply_refinements.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {
namespace {

constexpr int no_depth_limit = 1000;

}  // namespace

std::string to_string(LshapeScheme scheme) {
  switch (scheme) {
    case LshapeScheme::uniform:
      return "uniform";
    case LshapeScheme::adaptive:
      return "adaptive";
    default:
      return "directional";
  }
}

std::vector<Refinement> choose_refinements(LshapeScheme scheme, const LshapeRunOptions& options,
                                           const StaticSolution& solution) {
  const Mesh& mesh = solution.discretization.mesh;
  if (scheme == LshapeScheme::directional)
    return choose_templates(mesh, solution.estimate, options.directional, no_depth_limit);
  std::vector<Refinement> chosen;
  if (scheme == LshapeScheme::uniform) {
    for (int cell = 0; cell < mesh.cell_count(); ++cell) chosen.push_back({cell, {}});
  } else {
    const Eigen::VectorXd& eta = solution.estimate.eta;
    for (const int cell : mark_maximum(std::span(eta.data(), static_cast<std::size_t>(eta.size())), options.theta))
      chosen.push_back({cell, {}});
  }
  return chosen;
}

std::vector<LshapeStep> run_lshape(LshapeScheme scheme, const LshapeRunOptions& options,
                                   const LshapeObserver& observer) {
  LshapeProblem lshape = lshape_problem(options.problem);
  const StaticProblem problem{lshape.material, lshape.supports, lshape.loads, {}, options.solver};
  std::vector<LshapeStep> steps;
  FactorCache factors;
  std::optional<StaticSolution> solution;
  double mark_ms = 0.0, refine_ms = 0.0;
  for (;;) {
    // Uniform meshes start from zero: what they cost is what full refinement costs, not what a cascade of grids would.
    const bool warm = solution && scheme != LshapeScheme::uniform;
    solution = solve_static(lshape.forest, problem, warm ? &*solution : nullptr, factors);
    const Discretization& d = solution->discretization;
    LshapeStep step;
    step.scheme = scheme, step.step = static_cast<int>(steps.size());
    step.cells = d.mesh.cell_count(), step.nodes = d.mesh.node_count();
    step.hanging_nodes = d.hanging.hanging_count(), step.dofs = d.dof_count();
    step.iterations = solution->equilibrium.linear_iterations, step.converged = solution->equilibrium.converged;
    step.eta = solution->estimate.relative, step.estimated_error = solution->estimate.total;
    step.energy = solution->equilibrium.energy;
    step.mark_ms = mark_ms, step.topology_ms = refine_ms + solution->times.topology_ms;
    step.assemble_ms = solution->times.assemble_ms, step.reduce_ms = solution->times.reduce_ms;
    step.solve_ms = solution->times.solve_ms, step.estimate_ms = solution->times.estimate_ms;
    steps.push_back(step);
    if (!observer(step, *solution) || !step.converged || step.dofs >= options.enough_dofs) return steps;
    Stopwatch watch;
    const std::vector<Refinement> chosen = choose_refinements(scheme, options, *solution);
    mark_ms = watch.lap();
    if (apply_refinements(lshape.forest, d.mesh, chosen) == 0) return steps;
    refine_ms = watch.lap();
  }
}

}  // namespace finegauge
