#include "core/solve/conjugate_gradients.hpp"

#include "benchmarks/micro/lshape_workload.hpp"

using namespace finegauge;

namespace {

/// The multigrid-preconditioned solve from zero to a relative residual of 1e-6; matrix and preconditioner are there.
void conjugate_gradients_multigrid(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const LshapeSystem system = lshape_system(work);
  FactorCache factors;
  Multigrid multigrid(work.discretization, system.A, work.solution.u, work.hierarchy, factors);
  const Preconditioner cycle = [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) { multigrid.apply(r, z); };
  SolveReport report;
  Eigen::VectorXd x;
  for (auto _ : state) {
    x.setZero(system.b.size());
    report = conjugate_gradients(system.A, system.b, cycle, {}, x);
    benchmark::ClobberMemory();
  }
  if (!report.converged || !(relative_residual(system, x) <= 1e-6)) state.SkipWithError("the solve did not converge");
  count_sizes(state, work.discretization);
  state.counters["iterations"] = report.iterations;
}
BENCHMARK(conjugate_gradients_multigrid)->Apply(lshape_meshes);

/// Assembly and set-up included: what a step pays on a mesh that is there.
void assemble_and_solve_multigrid(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const Eigen::Matrix3Xd start = Eigen::Matrix3Xd::Zero(3, work.discretization.mesh.node_count());
  EquilibriumOptions options;
  options.method = LinearMethod::multigrid;
  Equilibrium solved;
  for (auto _ : state) {
    solved = solve_equilibrium(work.discretization, work.hierarchy, work.loads, start, options);
    benchmark::ClobberMemory();
  }
  if (!solved.converged || !((solved.u - work.solution.u).norm() < 1e-4 * work.solution.u.norm()))
    state.SkipWithError("the solution is not the one found before");
  count_sizes(state, work.discretization);
  state.counters["iterations"] = solved.linear_iterations;
}
BENCHMARK(assemble_and_solve_multigrid)->Apply(lshape_meshes);

/// One product with the reduced matrix, the inner loop of everything above.
void matrix_vector_product(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const LshapeSystem system = lshape_system(work);
  const Eigen::VectorXd x = gather(work.discretization.hanging, work.solution.u);
  Eigen::VectorXd Ax;
  for (auto _ : state) {
    multiply(system.A, x, Ax);
    benchmark::ClobberMemory();
  }
  if (!((system.b - Ax).norm() < 1e-6 * system.b.norm())) state.SkipWithError("A u is not the load");
  count_sizes(state, work.discretization);
}
BENCHMARK(matrix_vector_product)->Apply(lshape_meshes);

}  // namespace
