#include "benchmarks/micro/lshape_workload.hpp"
#include "core/adapt/stress_recovery.hpp"

using namespace finegauge;

namespace {

/// Stresses, recovery and the error of each cell with its direction.
void estimate_error(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  ErrorEstimate estimate;
  for (auto _ : state) {
    estimate = estimate_error_spr(work.discretization, work.solution.u);
    benchmark::ClobberMemory();
  }
  // A global share of the error in the energy: 1/5 on the coarsest mesh, 1/11 on the finest uniform one.
  if (estimate.eta != work.estimate.eta || !(estimate.relative > 0.05 && estimate.relative < 0.25))
    state.SkipWithError("the estimate is not that of before, or out of range");
  count_sizes(state, work.discretization);
  state.counters["eta"] = estimate.relative;
}
BENCHMARK(estimate_error)->Apply(lshape_meshes);

/// The same with the cells at singular edges weighted: what scenes use, and what it costs beside the line above.
void estimate_error_edges(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  ErrorEstimate estimate;
  for (auto _ : state) {
    estimate = finegauge::estimate_error(work.discretization, work.solution.u, Estimator::spr_edges);
    benchmark::ClobberMemory();
  }
  // The notch and the clamped rim hold half of the error: their weights of 2 and 4.4 raise it by a fifth or so.
  const double raised = estimate.total / work.estimate.total;
  if (!(raised > 1.02 && raised < 1.5)) state.SkipWithError("the weights change the estimate by more than they can");
  count_sizes(state, work.discretization);
  state.counters["eta"] = estimate.relative;
}
BENCHMARK(estimate_error_edges)->Apply(lshape_meshes);

/// The recovery alone.
void recover_stress(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const CellStresses stresses = cell_stresses(work.discretization, work.solution.u);
  Eigen::Matrix<double, 6, Eigen::Dynamic> recovered;
  for (auto _ : state) {
    recovered = recover_stress_spr(work.discretization, stresses);
    benchmark::ClobberMemory();
  }
  if (recovered != work.estimate.nodal_stress) state.SkipWithError("another stress than the estimate's");
  count_sizes(state, work.discretization);
}
BENCHMARK(recover_stress)->Apply(lshape_meshes);

}  // namespace
