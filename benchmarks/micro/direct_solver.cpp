#include "core/solve/direct_solver.hpp"

#include "benchmarks/micro/lshape_workload.hpp"

using namespace finegauge;

namespace {

/// CHOLMOD on the matrix of `conjugate_gradients_multigrid`: analyze, factor (supernodal where CHOLMOD finds that it
/// pays), solve. Our copy into its format is included; it is a few percent.
void cholmod_analyze_factor_solve(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const LshapeSystem system = lshape_system(work);
  Eigen::VectorXd x;
  double nonzeros = 0.0;
  bool factored = true;
  for (auto _ : state) {
    const DirectSolver solver(system.A);
    factored = factored && solver.factored();
    if (!factored) break;
    x = solver.solve(system.b);
    nonzeros = solver.factor_nonzeros();
  }
  if (!factored || !(relative_residual(system, x) < 1e-9)) state.SkipWithError("the solve is not exact");
  count_sizes(state, work.discretization);
  state.counters["factor_nonzeros"] = nonzeros;
}
BENCHMARK(cholmod_analyze_factor_solve)->Apply(lshape_meshes);

/// With the factor at hand, a right-hand side.
void cholmod_solve_factored(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const LshapeSystem system = lshape_system(work);
  const DirectSolver solver(system.A);
  if (!solver.factored()) {
    state.SkipWithError("the matrix could not be factored");
    return;
  }
  Eigen::VectorXd x;
  for (auto _ : state) x = solver.solve(system.b);
  if (!(relative_residual(system, x) < 1e-9)) state.SkipWithError("the solve is not exact");
  count_sizes(state, work.discretization);
}
BENCHMARK(cholmod_solve_factored)->Apply(lshape_meshes);

}  // namespace
