#include "core/needle/interaction.hpp"

#include <benchmark/benchmark.h>

#include <map>
#include <memory>
#include <utility>

#include "verification/support/dense_kkt.hpp"
#include "verification/support/needle_in_box.hpp"

using namespace finegauge;

namespace {

/// Two frames of a needle in a box, the second one's cells turned by up to a degree more: what a frame finds is a
/// factor, columns and impulses of the one before. Built once per size and count of points.
struct InteractionWorkload {
  NeedleInBox before, now;
  Eigen::VectorXd lambda;  ///< of `now`, solved tightly
};

const InteractionWorkload& interaction_workload(int cells, int points) {
  static std::map<std::pair<int, int>, std::unique_ptr<InteractionWorkload>> known;
  std::unique_ptr<InteractionWorkload>& work = known[{cells, points}];
  if (work) return *work;
  NeedleInBoxOptions options;
  options.cells = {2 * cells, cells, cells};
  options.points = points;
  options.elements = 16;
  options.axial = AxialLaw::friction;
  options.bend = 0.1;
  work = std::make_unique<InteractionWorkload>();
  work->before = needle_in_box(options);
  options.bend += 0.01745;
  work->now = needle_in_box(options);
  StepSolver solver;
  solver.set_matrix(work->before.A, false);
  const Interaction first = solve_interaction(work->before.system(), {}, solver);
  for (std::size_t p = 0; p < first.points.size(); ++p) work->now.points[p].lambda = first.points[p].lambda;
  solver.set_matrix(work->now.A, true);
  InteractionOptions tight;
  tight.tolerance = 1e-10;
  work->lambda = multipliers(solve_interaction(work->now.system(), tight, solver));
  return *work;
}

StepSolverOptions method_of(const benchmark::State& state) {
  return {state.range(2) != 0 ? StepMethod::kept : StepMethod::plain, {1e-9, 20000}};
}

void count_sizes(benchmark::State& state, const NeedleInBox& box) {
  state.counters["dofs"] = static_cast<double>(box.b.size());
  state.counters["points"] = static_cast<double>(box.points.size());
  state.counters["needle_dofs"] = static_cast<double>(box.needle_b.size());
}

/// Cells across the box, points, kept factor or plain conjugate gradients.
constexpr auto interaction_sizes = [](auto* registered) {
  registered->ArgNames({"cells", "points", "kept"})->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  for (const int kept : {0, 1})
    for (const auto& [cells, points] : {std::pair{5, 8}, std::pair{8, 8}, std::pair{8, 16}})
      registered->Args({cells, points, kept});
};

/// A frame's constrained solve from the last frame's factor, columns and impulses.
void solve_interaction_of_a_frame(benchmark::State& state) {
  const InteractionWorkload& work =
      interaction_workload(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  StepSolver solver(method_of(state));
  solver.set_matrix(work.before.A, false);
  bool converged = solve_interaction(work.before.system(), {}, solver).converged;
  Interaction found;
  const InteractionSystem system = work.now.system();
  for (auto _ : state) {
    solver.set_matrix(work.now.A, true);
    found = solve_interaction(system, {}, solver);
    benchmark::ClobberMemory();
  }
  converged = converged && found.converged;
  if (!converged || !((multipliers(found) - work.lambda).norm() < 1e-5 * work.lambda.norm()))
    state.SkipWithError("the impulses are not those found before");
  count_sizes(state, work.now);
  state.counters["uzawa_iterations"] = found.iterations;
  state.counters["linear_iterations"] = found.linear_iterations;
  state.counters["factorizations"] = solver.factorizations();
}
BENCHMARK(solve_interaction_of_a_frame)->Apply(interaction_sizes);

/// The same on another mesh: factor and columns are made anew.
void solve_interaction_after_refinement(benchmark::State& state) {
  const InteractionWorkload& work =
      interaction_workload(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  StepSolver solver(method_of(state));
  Interaction found;
  const InteractionSystem system = work.now.system();
  for (auto _ : state) {
    solver.set_matrix(work.now.A, false);
    found = solve_interaction(system, {}, solver);
    benchmark::ClobberMemory();
  }
  if (!found.converged || !((multipliers(found) - work.lambda).norm() < 1e-5 * work.lambda.norm()))
    state.SkipWithError("the impulses are not those found before");
  count_sizes(state, work.now);
  state.counters["uzawa_iterations"] = found.iterations;
  state.counters["linear_iterations"] = found.linear_iterations;
}
BENCHMARK(solve_interaction_after_refinement)->Apply(interaction_sizes);

/// A frame's linear solve without points, from a factor that is a degree old.
void step_solver_of_a_frame(benchmark::State& state) {
  const InteractionWorkload& work =
      interaction_workload(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  StepSolver solver(method_of(state));
  solver.set_matrix(work.before.A, false);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(work.now.b.size());
  bool converged = solver.solve(work.before.b, x).converged;
  SolveReport report;
  for (auto _ : state) {
    solver.set_matrix(work.now.A, true);
    x.setZero();
    report = solver.solve(work.now.b, x);
    benchmark::ClobberMemory();
  }
  converged = converged && report.converged;
  if (!converged || !(report.relative_residual <= 1e-9)) state.SkipWithError("the solve did not converge");
  count_sizes(state, work.now);
  state.counters["iterations"] = report.iterations;
  state.counters["factorizations"] = solver.factorizations();
}
BENCHMARK(step_solver_of_a_frame)->Apply(interaction_sizes);

}  // namespace
