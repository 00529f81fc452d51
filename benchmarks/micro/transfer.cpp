#include "core/space/transfer.hpp"

#include <cmath>

#include "benchmarks/micro/lshape_workload.hpp"
#include "core/adapt/marking.hpp"

using namespace finegauge;

namespace {

/// The displacement on the mesh of the next adaptive step: the start of the warm solve. Sizes are those of the mesh
/// that it comes from.
void transfer_to_refined(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  RefinementForest forest = work.problem.forest;
  const Mesh& coarse = work.discretization.mesh;
  refine_marked(forest, coarse, mark_maximum(work.eta(), lshape_theta));
  const Mesh fine = forest.leaf_mesh();
  Eigen::Matrix3Xd u;
  for (auto _ : state) {
    u = transfer(coarse, work.solution.u, fine);
    benchmark::ClobberMemory();
  }
  // There and back is the identity: refinement keeps the field and coarsening the nodes that remain.
  if (fine.node_count() <= coarse.node_count() ||
      !((transfer(fine, u, coarse) - work.solution.u).norm() < 1e-13 * work.solution.u.norm()))
    state.SkipWithError("there and back is not the identity");
  count_sizes(state, work.discretization);
  state.counters["new_nodes"] = fine.node_count() - coarse.node_count();
}
BENCHMARK(transfer_to_refined)->Apply(lshape_meshes);

/// One pass over all nodes: reduced displacement to every node and forces back.
void expand_and_reduce(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const HangingNodes& T = work.discretization.hanging;
  const Eigen::VectorXd x = gather(T, work.solution.u);
  Eigen::Matrix3Xd u;
  Eigen::VectorXd b;
  for (auto _ : state) {
    u = expand(T, x);
    b = reduce_forces(T, work.loads);
    benchmark::ClobberMemory();
  }
  // The work of the loads is the same in either space.
  const double nodal = (work.loads.array() * u.array()).sum(), reduced = b.dot(x);
  if (!(std::abs(nodal - reduced) < 1e-12 * std::abs(nodal))) state.SkipWithError("Tᵀ is not the adjoint of T");
  count_sizes(state, work.discretization);
}
BENCHMARK(expand_and_reduce)->Apply(lshape_meshes);

}  // namespace
