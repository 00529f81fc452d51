#include <cmath>

#include "benchmarks/micro/lshape_workload.hpp"

using namespace finegauge;

namespace {

/// Whether xᵀ A x is the energy of x, summed cell by cell without the matrix.
bool has_the_energy(const Discretization& d, const BlockMatrix<double>& A, const Eigen::Matrix3Xd& u) {
  const Eigen::VectorXd x = gather(d.hanging, u);
  Eigen::VectorXd Ax;
  multiply(A, x, Ax);
  const double energy = strain_energy_product(d, u);
  return energy > 0.0 && std::abs(x.dot(Ax) - energy) < 1e-10 * energy;
}

/// Both loops, from the reset of the matrix on.
void assemble(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const Discretization& d = work.discretization;
  BlockMatrix<double> A;
  for (auto _ : state) {
    A.reset(d.pattern);
    assemble_regular_cells(d, work.solution.u, A);
    assemble_hanging_cells(d, work.solution.u, A);
    benchmark::ClobberMemory();
  }
  if (!has_the_energy(d, A, work.solution.u)) state.SkipWithError("the matrix does not have the energy of the cells");
  count_sizes(state, d);
}
BENCHMARK(assemble)->Apply(lshape_meshes);

void assemble_regular(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const Discretization& d = work.discretization;
  BlockMatrix<double> A;
  for (auto _ : state) {
    state.PauseTiming();
    A.reset(d.pattern);
    state.ResumeTiming();
    assemble_regular_cells(d, work.solution.u, A);
    benchmark::ClobberMemory();
  }
  assemble_hanging_cells(d, work.solution.u, A);
  if (!has_the_energy(d, A, work.solution.u)) state.SkipWithError("the matrix does not have the energy of the cells");
  count_sizes(state, d);
  state.counters["assembled_cells"] = static_cast<double>(d.scatter.regular.size());
}
BENCHMARK(assemble_regular)->Apply(lshape_adaptive_meshes);

/// What the cells with hanging corners cost: their stiffness goes to masters through T.
void assemble_hanging(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const Discretization& d = work.discretization;
  BlockMatrix<double> A;
  for (auto _ : state) {
    state.PauseTiming();
    A.reset(d.pattern);
    state.ResumeTiming();
    assemble_hanging_cells(d, work.solution.u, A);
    benchmark::ClobberMemory();
  }
  assemble_regular_cells(d, work.solution.u, A);
  if (!has_the_energy(d, A, work.solution.u)) state.SkipWithError("the matrix does not have the energy of the cells");
  count_sizes(state, d);
  state.counters["assembled_cells"] = static_cast<double>(d.scatter.hanging.size());
}
BENCHMARK(assemble_hanging)->Apply(lshape_adaptive_meshes);

}  // namespace
