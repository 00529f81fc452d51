#include <cmath>
#include <vector>

#include "benchmarks/micro/lshape_workload.hpp"
#include "core/adapt/marking.hpp"
#include "core/mesh/hanging_nodes.hpp"

using namespace finegauge;

namespace {

/// All that an adaptive step pays before it can assemble: mark, refine, mesh, T, supports, pattern, multigrid levels.
/// Sizes are those of the new mesh.
void change_topology(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  Discretization d;
  MeshHierarchy hierarchy;
  for (auto _ : state) {
    state.PauseTiming();
    RefinementForest forest = work.problem.forest;
    state.ResumeTiming();
    refine_marked(forest, work.discretization.mesh, mark_maximum(work.eta(), lshape_theta));
    d = discretize(forest, work.problem.material, work.problem.supports);
    hierarchy = build_hierarchy(forest, d, work.problem.supports);
    benchmark::ClobberMemory();
  }
  const int marked = static_cast<int>(mark_maximum(work.eta(), lshape_theta).size());
  if (marked == 0 || d.mesh.cell_count() != work.discretization.mesh.cell_count() + 7 * marked ||
      hierarchy.coarse.empty())
    state.SkipWithError("the marked cells were not refined into eight");
  count_sizes(state, d);
}
BENCHMARK(change_topology)->Apply(lshape_meshes);

void leaf_mesh(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  Mesh mesh;
  for (auto _ : state) {
    mesh = work.problem.forest.leaf_mesh();
    benchmark::ClobberMemory();
  }
  double volume = 0.0;
  CellGeometry scratch;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    volume += work.discretization.shapes.geometry(mesh, cell, scratch).volume;
  if (!(std::abs(volume - 24.0) < 1e-9)) state.SkipWithError("the leaves do not fill the L-shape");
  count_sizes(state, work.discretization);
}
BENCHMARK(leaf_mesh)->Apply(lshape_meshes);

void hanging_nodes(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  HangingNodes T;
  for (auto _ : state) {
    T = find_hanging_nodes(work.problem.forest, work.discretization.mesh);
    benchmark::ClobberMemory();
  }
  const Mesh& mesh = work.discretization.mesh;
  const Eigen::Matrix3Xd linear = expand(T, gather(T, mesh.nodes));
  if (!((linear - mesh.nodes).cwiseAbs().maxCoeff() < 1e-12)) state.SkipWithError("T does not reproduce linear fields");
  count_sizes(state, work.discretization);
  state.counters["longest_chain"] = T.longest_chain;
}
BENCHMARK(hanging_nodes)->Apply(lshape_meshes);

/// Mesh, T, supports, rest shapes and pattern of one forest.
void discretize_forest(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  Discretization d;
  for (auto _ : state) {
    d = discretize(work.problem.forest, work.problem.material, work.problem.supports);
    benchmark::ClobberMemory();
  }
  if (d.pattern.column != work.discretization.pattern.column) state.SkipWithError("another pattern than before");
  count_sizes(state, d);
}
BENCHMARK(discretize_forest)->Apply(lshape_meshes);

/// The coarser meshes of the multigrid method, discretized, and the interpolations between them.
void multigrid_hierarchy(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  MeshHierarchy hierarchy;
  for (auto _ : state) {
    hierarchy = build_hierarchy(work.problem.forest, work.discretization, work.problem.supports);
    benchmark::ClobberMemory();
  }
  if (hierarchy.coarse.size() != work.hierarchy.coarse.size()) state.SkipWithError("another hierarchy than before");
  count_sizes(state, work.discretization);
  state.counters["levels"] = static_cast<double>(hierarchy.coarse.size() + 1);
}
BENCHMARK(multigrid_hierarchy)->Apply(lshape_meshes);

}  // namespace
