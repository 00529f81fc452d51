#include "core/adapt/marking.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "benchmarks/micro/lshape_workload.hpp"
#include "core/adapt/directional_marking.hpp"
#include "core/adapt/frame_adaptivity.hpp"

using namespace finegauge;

namespace {

void marking_maximum(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  std::vector<int> marked;
  for (auto _ : state) {
    marked = mark_maximum(work.eta(), lshape_theta);
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
    marked = mark_bulk(work.eta(), theta);
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

const FrameAdaptRules frame_rules{.refine_above = lshape_theta, .coarsen_below = 0.05, .max_depth = 30};

/// The von Mises stress of each cell at its centre: what marking a frame needs beside the estimate.
void frame_von_mises(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  Eigen::VectorXd stress;
  for (auto _ : state) {
    stress = cell_von_mises(work.discretization, work.solution.u);
    benchmark::ClobberMemory();
  }
  const CellStresses recovered = cell_stresses(work.discretization, work.solution.u);
  for (int cell = 0; cell < work.discretization.mesh.cell_count(); ++cell)
    if (!(std::abs(stress[cell] - von_mises(recovered.centre.col(cell))) <= 1e-12 * stress.maxCoeff()))
      state.SkipWithError("it is not that of the recovery");
  count_sizes(state, work.discretization);
}
BENCHMARK(frame_von_mises)->Apply(lshape_meshes);

/// One frame's marks under a load that rises and falls by a percent: refinement in every second frame, coarsening in
/// the others. The marks are not applied.
void frame_marking(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const Discretization& d = work.discretization;
  const Eigen::VectorXd low = cell_von_mises(d, work.solution.u), high = 1.01 * low;
  FrameAdaptHistory history;
  const auto mark = [&](int frame) {
    return mark_frame(work.problem.forest, d.mesh, work.estimate, frame % 2 ? high : low, frame, d.dof_count(),
                      frame_rules, history);
  };
  FrameMarks rising, falling;
  static_cast<void>(mark(0));
  int frame = 1;
  for (auto _ : state) {
    (frame % 2 ? rising : falling) = mark(frame);
    ++frame;
    benchmark::ClobberMemory();
  }
  while (frame < 3) (frame % 2 ? rising : falling) = mark(frame), ++frame;
  std::vector<int> refined;
  for (const Refinement& r : rising.refine) refined.push_back(r.cell);
  if (refined != mark_maximum(work.eta(), lshape_theta) || !rising.coarsen.empty() || !falling.refine.empty())
    state.SkipWithError("not the cells of the maximum strategy, or in a frame whose stress falls");
  count_sizes(state, d);
  state.counters["marked"] = static_cast<double>(refined.size());
  state.counters["families_marked"] = static_cast<double>(falling.coarsen.size());
}
BENCHMARK(frame_marking)->Apply(lshape_meshes);

/// Two frames' changes of the forest: the marked cells refined, and coarsened again; the history follows.
void frame_forest(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const Mesh& mesh = work.discretization.mesh;
  RefinementForest forest = work.problem.forest;
  FrameMarks refine, coarsen;
  for (const int cell : mark_maximum(work.eta(), lshape_theta)) {
    refine.refine.push_back({cell, {}});
    coarsen.coarsen.push_back(mesh.forest_cell[cell]);
  }
  std::sort(coarsen.coarsen.begin(), coarsen.coarsen.end());
  FrameAdaptHistory history;
  const Eigen::VectorXd stress = cell_von_mises(work.discretization, work.solution.u);
  static_cast<void>(mark_frame(forest, mesh, work.estimate, stress, 0, 0, frame_rules, history));
  int frame = 0, refined = 0, coarsened = 0;
  for (auto _ : state) {
    refined = adapt_forest(mesh, refine, ++frame, forest, history).refined;
    coarsened = adapt_forest(mesh, coarsen, ++frame, forest, history).coarsened;
    benchmark::ClobberMemory();
  }
  if (refined == 0 || refined != coarsened || forest.handle_count() != work.problem.forest.handle_count() ||
      forest.leaf_mesh().forest_cell != mesh.forest_cell)
    state.SkipWithError("the forest is not what it was");
  count_sizes(state, work.discretization);
  state.counters["refined"] = refined;
  state.counters["coarsened"] = coarsened;
}
BENCHMARK(frame_forest)->Apply(lshape_meshes);

}  // namespace
