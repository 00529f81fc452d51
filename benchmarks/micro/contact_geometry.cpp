#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "benchmarks/micro/lshape_workload.hpp"
#include "core/needle/tissue_coupling.hpp"
#include "verification/support/sample_cells.hpp"

/// What a needle asks of the tissue's geometry in a frame: a few calls each, so times are of one call.
namespace {

using namespace finegauge;

constexpr int point_count = 64;

/// Leaves of the solved L-shape, points in them and where the displacement has carried these.
struct ContactPoints {
  std::vector<LeafPoint> leaves;
  std::vector<MaterialPoint> points;
  std::vector<Eigen::Vector3d> positions;
};

ContactPoints contact_points(const LshapeWorkload& work) {
  const Mesh& mesh = work.discretization.mesh;
  std::mt19937 generator(1);
  ContactPoints contacts;
  for (int k = 0; k < point_count; ++k) {
    const LeafPoint leaf{static_cast<int>(generator() % static_cast<unsigned>(mesh.cell_count())),
                         (Eigen::Vector3d::Ones() + random_vector(generator)) / 2.0};
    contacts.leaves.push_back(leaf);
    contacts.points.push_back(material_point(mesh, leaf));
    contacts.positions.push_back(interpolate(mesh, mesh.nodes, leaf) + interpolate(mesh, work.solution.u, leaf));
  }
  return contacts;
}

void contact_meshes(benchmark::internal::Benchmark* registered) {
  registered->ArgNames({"adaptive", "dofs"})->Unit(benchmark::kMicrosecond);
  for (const int dofs : {6075, 42483}) registered->Args({0, dofs});
  registered->Args({1, 30000});
}

void count_geometry(benchmark::State& state, const Discretization& d) {
  count_sizes(state, d);
  state.counters["boundary_faces"] = static_cast<double>(d.mesh.boundary.size());
}

void locate(benchmark::State& state, bool with_hint) {
  const LshapeWorkload& work = lshape_workload(state);
  const Mesh& mesh = work.discretization.mesh;
  const ContactPoints contacts = contact_points(work);
  std::size_t k = 0;
  for (auto _ : state) {
    auto found =
        locate_deformed(mesh, work.solution.u, contacts.positions[k], with_hint ? contacts.leaves[k].cell : -1);
    benchmark::DoNotOptimize(found);
    k = (k + 1) % point_count;
  }
  for (std::size_t i = 0; i < point_count; ++i) {
    const auto found = locate_deformed(mesh, work.solution.u, contacts.positions[i]);
    const BaseMesh& base = work.problem.forest.base();
    if (!found || !((rest_position(base, *found) - rest_position(base, contacts.points[i])).norm() < 1e-12))
      state.SkipWithError("a point was located elsewhere");
  }
  count_geometry(state, work.discretization);
}
BENCHMARK_CAPTURE(locate, everywhere, false)->Apply(contact_meshes);
BENCHMARK_CAPTURE(locate, with_hint, true)->Apply(contact_meshes);

/// From outside to a point of the body.
void entry(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const Mesh& mesh = work.discretization.mesh;
  const ContactPoints contacts = contact_points(work);
  const Eigen::Vector3d outside(-1.0, 5.0, 3.0);
  std::size_t k = 0;
  for (auto _ : state) {
    auto hit = first_entry(mesh, work.solution.u, outside, contacts.positions[k]);
    benchmark::DoNotOptimize(hit);
    k = (k + 1) % point_count;
  }
  for (const Eigen::Vector3d& to : contacts.positions)
    if (const auto hit = first_entry(mesh, work.solution.u, outside, to);
        !hit || !((outside + hit->fraction * (to - outside) - hit->position).norm() < 1e-12))
      state.SkipWithError("a segment into the body does not enter it");
  count_geometry(state, work.discretization);
}
BENCHMARK(entry)->Apply(contact_meshes);

/// The reduced weights of a ring of eight points.
void reduced_weights(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const Discretization& d = work.discretization;
  const RefinementForest& forest = work.problem.forest;
  std::vector<SpreadPoint> spreads;
  for (const MaterialPoint& centre : contact_points(work).points)
    spreads.push_back(spread_over_ring(forest.base(), centre, {1.0, 0.3, -0.2}, 0.05));
  ReducedWeights weights;
  double nodes = 0.0;
  for (const SpreadPoint& spread : spreads) {
    find_reduced_weights(forest, d.mesh, d.hanging, spread, weights);
    double sum = 0.0;
    for (const double w : weights.weight) sum += w;
    if (!(std::abs(sum - 1.0) < 1e-13)) state.SkipWithError("weights do not sum to one");
    nodes += static_cast<double>(weights.node.size()) / point_count;
  }
  std::size_t k = 0;
  for (auto _ : state) {
    find_reduced_weights(forest, d.mesh, d.hanging, spreads[k], weights);
    benchmark::ClobberMemory();
    k = (k + 1) % point_count;
  }
  count_geometry(state, d);
  state.counters["nodes_of_a_point"] = nodes;
}
BENCHMARK(reduced_weights)->Apply(contact_meshes);

/// Eight points of a ring at rest, in the base mesh.
void ring(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const BaseMesh& base = work.problem.forest.base();
  const ContactPoints contacts = contact_points(work);
  std::size_t k = 0;
  for (auto _ : state) {
    const SpreadPoint spread = spread_over_ring(base, contacts.points[k], {1.0, 0.3, -0.2}, 0.05);
    benchmark::DoNotOptimize(spread.points.data());
    k = (k + 1) % point_count;
  }
  const SpreadPoint spread = spread_over_ring(base, contacts.points[0], {1.0, 0.3, -0.2}, 0.05);
  Eigen::Vector3d mean = -rest_position(base, contacts.points[0]);
  for (std::size_t p = 0; p < spread.points.size(); ++p)
    mean += spread.weights[p] * rest_position(base, spread.points[p]);
  if (!(mean.norm() < 1e-13)) state.SkipWithError("the ring's mean is not its centre");
  count_geometry(state, work.discretization);
  state.counters["base_cells"] = static_cast<double>(base.cells.size());
}
BENCHMARK(ring)->Apply(contact_meshes);

}  // namespace
