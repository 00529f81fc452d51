#include "benchmarks/program/static_run.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "benchmarks/program/optional_field.hpp"
#include "benchmarks/program/quantity_points.hpp"
#include "benchmarks/program/static_notes.hpp"
#include "core/adapt/apply_refinements.hpp"
#include "core/adapt/directional_marking.hpp"
#include "core/adapt/marking.hpp"
#include "core/scene/check_held.hpp"
#include "core/scene/start_forest.hpp"
#include "core/static_step.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {
namespace {

std::vector<int> mark(const AdaptRules& rules, const Eigen::VectorXd& eta_of_cells) {
  const std::span<const double> eta(eta_of_cells.data(), static_cast<std::size_t>(eta_of_cells.size()));
  switch (rules.marking) {
    case Marking::maximum:
      return mark_maximum(eta, rules.theta);
    case Marking::bulk:
      return mark_bulk(eta, rules.theta);
    case Marking::fraction:
      return mark_fraction(eta, rules.theta);
    case Marking::threshold:
      return mark_above(eta, rules.threshold);
  }
  throw std::logic_error("marking strategy out of range");
}

/// What the rules refine, cells by their number in the mesh; cells at the depth limit are left.
std::vector<Refinement> choose_refinements(const AdaptRules& rules, const RefinementForest& forest, const Mesh& mesh,
                                           const ErrorEstimate& estimate) {
  std::vector<Refinement> chosen;
  if (rules.policy == RefinementPolicy::directional) {
    DirectionalMarking marking;
    marking.theta = rules.theta;
    chosen = choose_templates(mesh, estimate, marking, rules.max_depth);
    std::erase_if(chosen,
                  [&](const Refinement& r) { return !forest.can_refine(mesh.forest_cell[r.cell], r.refinement); });
    return chosen;
  }
  for (const int cell : mark(rules, estimate.eta)) {
    const int leaf = mesh.forest_cell[cell];
    const auto& divisions = rules.refinement.divisions;
    const int levels = std::ranges::find(divisions, 4) == divisions.end() ? 1 : 2;  // apply_refinements.hpp
    if (mesh.frames[cell].depth + levels <= rules.max_depth && forest.can_refine(leaf, rules.refinement))
      chosen.push_back({cell, rules.refinement});
  }
  return chosen;
}

Json quantities_of_interest(const Scene& scene, const std::vector<std::optional<MaterialPoint>>& points,
                            const RefinementForest& forest, const Mesh& mesh, const Equilibrium& equilibrium) {
  Json values = Json::object();
  for (std::size_t i = 0; i < scene.quantities.size(); ++i) {
    const QuantityOfInterest& quantity = scene.quantities[i];
    if (quantity.kind == QuantityKind::energy) {
      values[quantity.name] = equilibrium.energy;
      continue;
    }
    const Eigen::Vector3d u = interpolate(mesh, equilibrium.u, find_leaf(forest, mesh, points[i].value()));
    values[quantity.name] = {u.x(), u.y(), u.z()};
  }
  return values;
}

/// Why the loop ends after this step; empty while it goes on. What is marked comes afterwards.
std::string reason_to_stop(const std::optional<AdaptRules>& rules, const StaticStep& step) {
  if (!step.converged) return "the solve did not converge";
  if (!rules) return "the scene has no adaptivity";
  if (step.tolerance_met) return "the tolerance is met";
  if (step.step >= rules->steps) return "all steps are done";
  if (step.dofs >= rules->max_dofs) return "max_dofs is reached";
  return {};
}

}  // namespace

Json to_json(const StaticStep& s) {
  Json row = {{"step", s.step},
              {"cells", s.cells},
              {"nodes", s.nodes},
              {"hanging_nodes", s.hanging_nodes},
              {"dofs", s.dofs},
              {"eta", s.eta},
              {"eta_local_max", s.eta_local_max},
              {"tolerance_met", s.tolerance_met},
              {"converged", s.converged},
              {"residual", s.residual},
              {"iterations", s.iterations},
              {"newton_iterations", s.newton_iterations},
              {"strain_energy", s.strain_energy}};
  put(row, "error_low", s.certified.has_value(), s.certified ? s.certified->low : 0.0, s.uncertified.c_str());
  put(row, "error_high", s.certified.has_value(), s.certified ? s.certified->high : 0.0, s.uncertified.c_str());
  if (!s.quantities.empty()) row["quantities"] = s.quantities;
  row["estimate_ms"] = s.estimate_ms, row["mark_ms"] = s.mark_ms, row["topology_ms"] = s.topology_ms;
  row["assemble_ms"] = s.assemble_ms, row["reduce_ms"] = s.reduce_ms, row["solve_ms"] = s.solve_ms;
  row["total_ms"] = s.total_ms;
  return row;
}

StaticRun run_static(const Scene& scene, const StaticObserver& observer) {
  RefinementForest forest = start_forest(scene);
  const StaticProblem problem{scene.material, support_conditions(scene), scene.loads,    body_force(scene),
                              scene.solver,   spring_supports(scene),    scene.estimator};
  StaticRun run;
  std::vector<Refinement> chosen;
  FactorCache factors;
  std::optional<StaticSolution> solution;
  const std::vector<std::optional<MaterialPoint>> points = quantity_points(scene, forest.base());
  for (int number = 0;; ++number) {
    StaticStep step;
    step.step = number;
    Stopwatch watch;
    if (solution) run.refined += apply_refinements(forest, solution->discretization.mesh, chosen);
    Discretization discretization =
        discretize(forest, forest.leaf_mesh(), problem.material, problem.supports, problem.springs);
    step.topology_ms = watch.lap();
    if (number == 0) check_held(scene, forest.topology(), discretization);  // before anything is solved or written
    solution = solve_static(forest, std::move(discretization), problem, solution ? &*solution : nullptr, factors);
    const Discretization& d = solution->discretization;
    const Equilibrium& equilibrium = solution->equilibrium;
    const ErrorEstimate& estimate = solution->estimate;
    step.topology_ms += solution->times.topology_ms;
    step.assemble_ms = solution->times.assemble_ms, step.reduce_ms = solution->times.reduce_ms;
    step.solve_ms = solution->times.solve_ms, step.estimate_ms = solution->times.estimate_ms;

    step.cells = d.mesh.cell_count(), step.nodes = d.mesh.node_count();
    step.hanging_nodes = d.hanging.hanging_count(), step.dofs = d.dof_count();
    step.eta = estimate.relative;
    step.certified = certified_range(scene, step.eta, equilibrium.converged);
    step.uncertified = why_uncertified(scene, step.eta, equilibrium.converged);
    step.eta_local_max = estimate.energy_norm > 0.0 ? estimate.eta.maxCoeff() / estimate.energy_norm : 0.0;
    step.tolerance_met = scene.adapt && scene.adapt->tolerance > 0.0 && estimate.relative <= scene.adapt->tolerance;
    step.converged = equilibrium.converged, step.residual = equilibrium.relative_residual;
    step.iterations = equilibrium.linear_iterations, step.newton_iterations = equilibrium.newton_iterations;
    step.strain_energy = 0.5 * equilibrium.energy;
    step.quantities = quantities_of_interest(scene, points, forest, d.mesh, equilibrium);
    run.stopped_because = reason_to_stop(scene.adapt, step);
    if (run.stopped_because.empty()) {
      watch.lap();
      chosen = choose_refinements(*scene.adapt, forest, d.mesh, estimate);
      step.mark_ms = watch.lap();
      if (chosen.empty()) run.stopped_because = "no cell is left to refine";
    }
    step.total_ms =
        step.topology_ms + step.assemble_ms + step.reduce_ms + step.solve_ms + step.estimate_ms + step.mark_ms;
    run.steps.push_back(step);
    run.u = equilibrium.u;

    const bool last = !run.stopped_because.empty();
    const bool go_on = observer({step, forest, d, run.u, estimate, last});
    if (last || !go_on) {
      if (!last) run.stopped_because = "interrupted";
      run.notes = static_notes(scene, d, run.u);
      return run;
    }
  }
}

}  // namespace finegauge
