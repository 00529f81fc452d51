#include "benchmarks/program/static_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>

#include "benchmarks/program/material_point.hpp"
#include "core/adapt/marking.hpp"
#include "core/scene/check_held.hpp"
#include "core/scene/scene_error.hpp"
#include "core/solve/multigrid.hpp"
#include "core/space/loads.hpp"
#include "core/space/transfer.hpp"

namespace finegauge {
namespace {

class Stopwatch {
 public:
  /// Milliseconds since construction or the last call.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void refine_initially(RefinementForest& forest, const std::vector<InitialRefinement>& refinements) {
  for (const InitialRefinement& region : refinements)
    for (int level = 0; level < region.levels; ++level) {
      const Mesh mesh = forest.leaf_mesh();
      const int corners = corner_count(mesh.shape);
      for (int e = 0; e < mesh.cell_count(); ++e) {
        const Eigen::Vector3d centre = corner_values(mesh, e, mesh.nodes).leftCols(corners).rowwise().mean();
        const bool within =
            (centre.array() >= region.min.array()).all() && (centre.array() <= region.max.array()).all();
        if (within && forest.can_refine(mesh.forest_cell[e], region.refinement))
          forest.refine(mesh.forest_cell[e], region.refinement);
      }
    }
}

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
  for (const int cell : mark(rules, estimate.eta)) {
    const int leaf = mesh.forest_cell[cell];
    if (mesh.frames[cell].depth < rules.max_depth && forest.can_refine(leaf, rules.refinement))
      chosen.push_back({cell, rules.refinement});
  }
  return chosen;
}

void check_points(const Scene& scene, const Mesh& mesh) {
  for (const QuantityOfInterest& quantity : scene.quantities)
    if (quantity.kind == QuantityKind::displacement && !locate(mesh, quantity.point)) {
      const Eigen::Vector3d& p = quantity.point;
      throw SceneError(scene.file + ": quantity.point of \"" + quantity.name + "\": found " +
                       Json({p.x(), p.y(), p.z()}).dump() + ", allowed are points of the body");
    }
}

Json quantities_of_interest(const Scene& scene, const Mesh& mesh, const Equilibrium& equilibrium) {
  Json values = Json::object();
  for (const QuantityOfInterest& quantity : scene.quantities) {
    if (quantity.kind == QuantityKind::energy) {
      values[quantity.name] = equilibrium.energy;
      continue;
    }
    const Eigen::Vector3d u = interpolate(mesh, locate(mesh, quantity.point).value(), equilibrium.u);
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
  if (!s.quantities.empty()) row["quantities"] = s.quantities;
  row["estimate_ms"] = s.estimate_ms, row["mark_ms"] = s.mark_ms, row["topology_ms"] = s.topology_ms;
  row["assemble_ms"] = s.assemble_ms, row["reduce_ms"] = s.reduce_ms, row["solve_ms"] = s.solve_ms;
  row["total_ms"] = s.total_ms;
  return row;
}

StaticRun run_static(const Scene& scene, const StaticObserver& observer) {
  if (scene.adapt && scene.adapt->policy == RefinementPolicy::directional)
    throw SceneError(scene.file +
                     ": adapt.policy: found \"directional\", which run cannot do; allowed is \"template\"");
  RefinementForest forest(base_mesh(scene));
  refine_initially(forest, scene.refinements);
  const std::vector<SupportCondition> supports = support_conditions(scene);
  const BodyForce body = body_force(scene);
  StaticRun run;
  std::vector<Refinement> chosen;
  Mesh mesh_before;
  for (int number = 0;; ++number) {
    StaticStep step;
    step.step = number;
    Stopwatch watch;
    for (const Refinement& r : chosen) forest.refine(mesh_before.forest_cell[r.cell], r.refinement);
    run.refined += static_cast<int>(chosen.size());
    const Discretization d = discretize(forest, scene.material, supports);
    const MeshHierarchy hierarchy = build_hierarchy(forest, d, supports);
    const Eigen::Matrix3Xd start = number ? transfer(mesh_before, run.u, d.mesh)
                                          : Eigen::Matrix3Xd(Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
    step.topology_ms = watch.lap();
    if (number == 0) {
      check_held(scene, d);
      check_points(scene, d.mesh);
      watch.lap();
    }
    const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, scene.loads, body);
    const double loads_ms = watch.lap();
    Equilibrium equilibrium = solve_equilibrium(d, hierarchy, loads, start, scene.solver);
    step.assemble_ms = loads_ms + equilibrium.times.assemble_ms;
    step.reduce_ms = equilibrium.times.reduce_ms, step.solve_ms = equilibrium.times.solve_ms;
    watch.lap();
    const ErrorEstimate estimate = estimate_error_spr(d, equilibrium.u);
    step.estimate_ms = watch.lap();

    step.cells = d.mesh.cell_count(), step.nodes = d.mesh.node_count();
    step.hanging_nodes = d.hanging.hanging_count(), step.dofs = d.dof_count();
    step.eta = estimate.relative;
    step.eta_local_max = estimate.energy_norm > 0.0 ? estimate.eta.maxCoeff() / estimate.energy_norm : 0.0;
    step.tolerance_met = scene.adapt && scene.adapt->tolerance > 0.0 && estimate.relative <= scene.adapt->tolerance;
    step.converged = equilibrium.converged, step.residual = equilibrium.relative_residual;
    step.iterations = equilibrium.linear_iterations, step.newton_iterations = equilibrium.newton_iterations;
    step.strain_energy = 0.5 * equilibrium.energy;
    step.quantities = quantities_of_interest(scene, d.mesh, equilibrium);
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
    run.u = std::move(equilibrium.u);

    const bool last = !run.stopped_because.empty();
    const bool go_on = observer({step, d, run.u, estimate, last});
    if (last) return run;
    if (!go_on) {
      run.stopped_because = "interrupted";
      return run;
    }
    mesh_before = d.mesh;
  }
}

}  // namespace finegauge
