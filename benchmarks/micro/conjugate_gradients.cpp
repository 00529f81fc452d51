#include "core/solve/conjugate_gradients.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>
#include <Eigen/OrderingMethods>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

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

/// The same solve with what multigrid was chosen over; set-up is timed, since it is what multigrid has to make up for.
void conjugate_gradients_with(benchmark::State& state,
                              const std::function<Preconditioner(const BlockMatrix<double>&)>& set_up) {
  const LshapeWorkload& work = lshape_workload(state);
  const LshapeSystem system = lshape_system(work);
  SolveReport report;
  Eigen::VectorXd x;
  for (auto _ : state) {
    const Preconditioner M = set_up(system.A);
    x.setZero(system.b.size());
    report = conjugate_gradients(system.A, system.b, M, {.relative_residual = 1e-6, .iterations = 10000}, x);
    benchmark::ClobberMemory();
  }
  if (!report.converged || !(relative_residual(system, x) <= 1e-6)) state.SkipWithError("the solve did not converge");
  count_sizes(state, work.discretization);
  state.counters["iterations"] = report.iterations;
}

void conjugate_gradients_multigrid_with_set_up(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  conjugate_gradients_with(state, [&](const BlockMatrix<double>& A) -> Preconditioner {
    FactorCache factors;
    const auto multigrid =
        std::make_shared<Multigrid>(work.discretization, A, work.solution.u, work.hierarchy, factors);
    return [multigrid](const Eigen::VectorXd& r, Eigen::VectorXd& z) { multigrid->apply(r, z); };
  });
}
BENCHMARK(conjugate_gradients_multigrid_with_set_up)->Apply(lshape_meshes);

void conjugate_gradients_block_jacobi(benchmark::State& state) {
  conjugate_gradients_with(state, [](const BlockMatrix<double>& A) -> Preconditioner {
    std::vector<Eigen::Matrix3d> inverse;
    for (const int diagonal : A.pattern->diagonal) inverse.push_back(A.block(diagonal).inverse());
    return [inverse = std::move(inverse)](const Eigen::VectorXd& r, Eigen::VectorXd& z) {
      z.resize(r.size());
      for (std::size_t i = 0; i < inverse.size(); ++i) {
        const auto at = static_cast<Eigen::Index>(3 * i);
        z.segment<3>(at) = inverse[i] * r.segment<3>(at);
      }
    };
  });
}
BENCHMARK(conjugate_gradients_block_jacobi)->Apply(lshape_meshes);

/// Eigen's incomplete Cholesky factorization (Lin & Moré 1999).
void conjugate_gradients_incomplete_cholesky(benchmark::State& state) {
  conjugate_gradients_with(state, [](const BlockMatrix<double>& A) -> Preconditioner {
    const auto factor =
        std::make_shared<Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::AMDOrdering<int>>>(to_sparse(A));
    return [factor](const Eigen::VectorXd& r, Eigen::VectorXd& z) { z = factor->solve(r); };
  });
}
BENCHMARK(conjugate_gradients_incomplete_cholesky)->Apply(lshape_meshes);

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
