#include "core/static_step.hpp"

#include <algorithm>
#include <utility>

#include "core/space/free_surface.hpp"
#include "core/space/transfer.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {

namespace {

/// Where supports move the body at all, by so little beside its own displacement that they do none of the work; and no
/// spring takes part of it, whose energy the estimate does not count.
bool is_driven_by_loads(const Discretization& d, const Eigen::Matrix3Xd& u) {
  const double none = 1e-6 * u.cwiseAbs().maxCoeff();
  return d.springs.empty() && std::ranges::all_of(d.supports.displacement, [none](const Eigen::Vector3d& prescribed) {
           return prescribed.cwiseAbs().maxCoeff() <= none;
         });
}

}  // namespace

StaticSolution solve_static(const RefinementForest& forest, const StaticProblem& problem, const StaticSolution* before,
                            FactorCache& factors) {
  Stopwatch watch;
  Discretization discretization =
      discretize(forest, forest.leaf_mesh(), problem.material, problem.supports, problem.springs);
  const double discretize_ms = watch.lap();
  StaticSolution solution = solve_static(forest, std::move(discretization), problem, before, factors);
  solution.times.topology_ms += discretize_ms;
  return solution;
}

StaticSolution solve_static(const RefinementForest& forest, Discretization discretization, const StaticProblem& problem,
                            const StaticSolution* before, FactorCache& factors) {
  StaticSolution solution;
  Stopwatch watch;
  solution.discretization = std::move(discretization);
  solution.discretization.free_surface =
      find_free_surface(forest, solution.discretization, problem.supports, problem.loads);
  const Discretization& d = solution.discretization;
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, problem.supports);
  solution.multigrid_levels = 1 + static_cast<int>(hierarchy.coarse.size());
  const Eigen::Matrix3Xd start = before ? transfer(before->discretization.mesh, before->equilibrium.u, d.mesh)
                                        : Eigen::Matrix3Xd(Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
  solution.times.topology_ms = watch.lap();
  const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, problem.loads, problem.body);
  solution.times.assemble_ms = watch.lap();
  solution.equilibrium = solve_equilibrium(d, hierarchy, loads, start, problem.solver, &factors);
  solution.times.assemble_ms += solution.equilibrium.times.assemble_ms;
  solution.times.reduce_ms = solution.equilibrium.times.reduce_ms;
  solution.times.solve_ms = solution.equilibrium.times.solve_ms;
  watch.lap();
  solution.discretization.driven_by_loads = is_driven_by_loads(d, solution.equilibrium.u);
  solution.estimate = estimate_error(d, solution.equilibrium.u, problem.estimator);
  solution.times.estimate_ms = watch.lap();
  return solution;
}

}  // namespace finegauge
