#include "core/solve/multigrid.hpp"

#include <algorithm>
#include <cmath>

#include "benchmarks/micro/lshape_workload.hpp"

using namespace finegauge;

namespace {

/// Matrices of the coarser meshes, diagonal blocks, the factorization of the coarsest. The meshes themselves are
/// `multigrid_hierarchy`.
void multigrid_setup(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const LshapeSystem system = lshape_system(work);
  bool usable = true;
  for (auto _ : state) {
    FactorCache factors;
    const Multigrid multigrid(work.discretization, system.A, work.solution.u, work.hierarchy, factors);
    usable = usable && multigrid.usable();
  }
  if (!usable) state.SkipWithError("the coarsest matrix could not be factored");
  count_sizes(state, work.discretization);
  state.counters["levels"] = static_cast<double>(work.hierarchy.coarse.size() + 1);
}
BENCHMARK(multigrid_setup)->Apply(lshape_meshes);

/// The same with the factor of the coarsest matrix kept from the step before.
void multigrid_setup_factor_kept(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const LshapeSystem system = lshape_system(work);
  FactorCache factors;
  bool usable = Multigrid(work.discretization, system.A, work.solution.u, work.hierarchy, factors).usable();
  for (auto _ : state) {
    const Multigrid multigrid(work.discretization, system.A, work.solution.u, work.hierarchy, factors);
    usable = usable && multigrid.usable();
  }
  if (!usable) state.SkipWithError("the coarsest matrix could not be factored");
  count_sizes(state, work.discretization);
}
BENCHMARK(multigrid_setup_factor_kept)->Apply(lshape_meshes);

/// One V-cycle.
void multigrid_apply(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const LshapeSystem system = lshape_system(work);
  FactorCache factors;
  Multigrid multigrid(work.discretization, system.A, work.solution.u, work.hierarchy, factors);
  Eigen::VectorXd z;
  for (auto _ : state) {
    multigrid.apply(system.b, z);
    benchmark::ClobberMemory();
  }
  // z approximates A⁻¹ b: in the energy norm |x - z|² = bᵀx - 2 zᵀb + zᵀAz must be well below |x|² = bᵀx.
  Eigen::VectorXd Az;
  multiply(system.A, z, Az);
  const double exact = work.solution.energy, distance = exact - 2.0 * z.dot(system.b) + z.dot(Az);
  if (!(distance < 0.25 * exact)) state.SkipWithError("a cycle does not halve the error of the start from zero");
  count_sizes(state, work.discretization);
  state.counters["error_reduction"] = std::sqrt(std::max(0.0, distance) / exact);
}
BENCHMARK(multigrid_apply)->Apply(lshape_meshes);

}  // namespace
