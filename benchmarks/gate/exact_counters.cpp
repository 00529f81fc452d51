#include <stdexcept>
#include <utility>

#include "benchmarks/gate/gate.hpp"
#include "benchmarks/paper/lshape_problem.hpp"
#include "core/adapt/apply_refinements.hpp"
#include "core/adapt/error_estimate.hpp"
#include "core/adapt/marking.hpp"
#include "core/equilibrium.hpp"
#include "core/solve/direct_solver.hpp"

namespace finegauge {
namespace {

constexpr double theta = 0.3;  // the paper's
constexpr int adaptive_dofs = 5000;

Json counters_of(LshapeProblem& problem, bool refine) {
  while (true) {
    const Discretization d = discretize(problem.forest, problem.material, problem.supports);
    const MeshHierarchy hierarchy = build_hierarchy(problem.forest, d, problem.supports);
    const Eigen::Matrix3Xd loads = nodal_loads(problem.forest.base(), d.mesh, problem.loads);
    EquilibriumOptions options;
    options.method = LinearMethod::multigrid;
    options.linear.relative_residual = 1e-8;
    const Eigen::Matrix3Xd start = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
    const Equilibrium solution = solve_equilibrium(d, hierarchy, loads, start, options);
    if (!solution.converged) throw std::runtime_error("the L-shape could not be solved");
    if (!refine || d.dof_count() >= adaptive_dofs) {
      BlockMatrix<double> A = assemble_stiffness(d, start);
      apply_supports(d.supports, A);
      const DirectSolver solver(A);
      if (!solver.factored()) throw std::runtime_error("the L-shape's matrix could not be factored");
      return {{"dofs", d.dof_count()},
              {"cells", d.mesh.cell_count()},
              {"hanging_nodes", d.hanging.hanging_count()},
              {"entries_of_T", d.hanging.weight.size()},
              {"blocks", d.pattern.block_count()},
              {"factor_nonzeros", solver.factor_nonzeros()},
              {"iterations", solution.linear_iterations}};
    }
    const ErrorEstimate estimate = estimate_error_spr(d, solution.u);
    const std::vector<int> marked =
        mark_maximum({estimate.eta.data(), static_cast<std::size_t>(estimate.eta.size())}, theta);
    for (const int cell : marked) problem.forest.refine(d.mesh.forest_cell[cell], {});
  }
}

}  // namespace

Json exact_counters() {
  LshapeProblem uniform = lshape_problem(), adaptive = lshape_problem();
  refine_uniformly(uniform.forest);
  return {{"uniform", counters_of(uniform, false)}, {"adaptive", counters_of(adaptive, true)}};
}

}  // namespace finegauge
