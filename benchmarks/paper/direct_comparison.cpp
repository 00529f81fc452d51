#include "benchmarks/paper/direct_comparison.hpp"

#include <algorithm>
#include <vector>

#include "core/adapt/apply_refinements.hpp"
#include "core/equilibrium.hpp"
#include "core/solve/direct_solver.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {
namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

DirectComparison compare_with_direct(const LshapeOptions& problem, int passes,
                                     const std::function<void(double, const std::string&)>& progress) {
  LshapeProblem lshape = lshape_problem(problem);
  refine_uniformly(lshape.forest);
  refine_uniformly(lshape.forest);
  DirectComparison comparison;
  std::vector<double> multigrid, direct, topology;
  for (int pass = 0; pass < passes; ++pass) {
    progress(1.0, "multigrid against CHOLMOD, pass " + std::to_string(pass + 1) + " of " + std::to_string(passes));
    Stopwatch watch;
    const Discretization d = discretize(lshape.forest, lshape.material, lshape.supports);
    topology.push_back(watch.lap());
    const Eigen::Matrix3Xd loads = nodal_loads(lshape.forest.base(), d.mesh, lshape.loads);
    const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
    EquilibriumOptions options;
    options.method = LinearMethod::multigrid;
    options.linear.relative_residual = 1e-6;
    watch.lap();
    const MeshHierarchy hierarchy = build_hierarchy(lshape.forest, d, lshape.supports);
    const Equilibrium equilibrium = solve_equilibrium(d, hierarchy, loads, zero, options);
    multigrid.push_back(watch.lap());
    comparison.dofs = d.dof_count();
    comparison.iterations = equilibrium.linear_iterations;
    comparison.relative_residual = equilibrium.relative_residual;

    BlockMatrix<double> A = assemble_stiffness(d, zero);
    apply_supports(d.supports, A);
    Eigen::VectorXd b = reduce_forces(d.hanging, loads);
    project(d.supports, b);
    watch.lap();
    const DirectSolver solver(A);
    if (solver.factored()) solver.solve(b);
    direct.push_back(watch.lap());
  }
  comparison.multigrid_ms = median(multigrid);
  comparison.direct_ms = median(direct);
  comparison.topology_ms = median(topology);
  return comparison;
}

Json to_json(const DirectComparison& c) {
  return {{"dofs", c.dofs},
          {"multigrid_ms", c.multigrid_ms},
          {"cholmod_ms", c.direct_ms},
          {"ratio", c.ratio()},
          {"topology_ms", c.topology_ms},
          {"iterations", c.iterations},
          {"relative_residual", c.relative_residual}};
}

}  // namespace finegauge
