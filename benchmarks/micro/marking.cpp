#include "core/adapt/marking.hpp"

#include <algorithm>
#include <span>
#include <vector>

#include "benchmarks/micro/lshape_workload.hpp"
#include "core/adapt/directional_marking.hpp"

using namespace finegauge;

namespace {

std::span<const double> eta(const LshapeWorkload& work) {
  return {work.estimate.eta.data(), static_cast<std::size_t>(work.estimate.eta.size())};
}

void marking_maximum(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  std::vector<int> marked;
  for (auto _ : state) {
    marked = mark_maximum(eta(work), lshape_theta);
    benchmark::ClobberMemory();
  }
  Eigen::Index worst = 0;
  work.estimate.eta.maxCoeff(&worst);
  if (!std::binary_search(marked.begin(), marked.end(), static_cast<int>(worst)))
    state.SkipWithError("the worst cell is not marked");
  count_sizes(state, work.discretization);
  state.counters["marked"] = static_cast<double>(marked.size());
}
BENCHMARK(marking_maximum)->Apply(lshape_meshes);

/// The one strategy that sorts.
void marking_bulk(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  constexpr double theta = 0.5;
  std::vector<int> marked;
  for (auto _ : state) {
    marked = mark_bulk(eta(work), theta);
    benchmark::ClobberMemory();
  }
  double squares = 0.0;
  for (const int cell : marked) squares += work.estimate.eta[cell] * work.estimate.eta[cell];
  if (!(squares >= theta * theta * work.estimate.eta.squaredNorm() * (1.0 - 1e-12)))
    state.SkipWithError("the marked cells have too little of the error");
  count_sizes(state, work.discretization);
  state.counters["marked"] = static_cast<double>(marked.size());
}
BENCHMARK(marking_bulk)->Apply(lshape_meshes);

/// A template for each cell, by the direction of its error.
void marking_directional(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  std::vector<Refinement> refinements;
  for (auto _ : state) {
    refinements = choose_templates(work.discretization.mesh, work.estimate, {}, 30);
    benchmark::ClobberMemory();
  }
  // The solution hardly varies along z: some cell must be left whole along it.
  const bool directional = std::any_of(refinements.begin(), refinements.end(),
                                       [](const Refinement& r) { return r.refinement.divisions[2] == 1; });
  if (!directional) state.SkipWithError("every marked cell is divided along z");
  count_sizes(state, work.discretization);
  state.counters["marked"] = static_cast<double>(refinements.size());
}
BENCHMARK(marking_directional)->Apply(lshape_meshes);

}  // namespace
