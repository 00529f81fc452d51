#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "benchmarks/micro/lshape_workload.hpp"
#include "benchmarks/paper/lshape_run.hpp"
#include "core/adapt/apply_refinements.hpp"

using namespace finegauge;

namespace {

/// The paper's Table 1 as a benchmark: the whole step that leads to one mesh of the L-shape, from the mesh before it.
/// Adaptive and directional sequences are the study's own (paper/lshape_run.hpp): the step starts from the solution and
/// estimate of the mesh before, and ends with its own. A uniform mesh is refined from the mesh of half its resolution
/// and starts from zero; it needs no estimate and no marks, so none is timed. Each finds the factor of the base mesh,
/// as steps of a sequence do.
struct StepWorkload {
  LshapeScheme scheme;
  LshapeRunOptions options;
  StaticProblem problem;
  RefinementForest forest;  ///< of the mesh before
  StaticSolution before;
  FactorCache factors;
};

/// The energy of the exact solution. The file is the program's; a line of it does not need the program's parser.
double read_exact_energy() {
  std::ifstream stream(std::string(FINEGAUGE_SOURCE_DIR) + "/reference_data/exact/lshape.json");
  const std::string text{std::istreambuf_iterator<char>(stream), {}}, key = "\"value\":";
  const std::size_t at = text.find(key);
  if (at == std::string::npos) throw std::runtime_error("reference_data/exact/lshape.json has no value");
  return std::stod(text.substr(at + key.size()));
}
double exact_energy() {
  static const double energy = read_exact_energy();
  return energy;
}

/// Nodes of the uniform mesh with n cells on the long edge: a square less a quadrant, n / 2 cells thick.
int uniform_dofs(int n) { return 3 * ((n + 1) * (n + 1) - n * n / 4) * (n / 2 + 1); }

StepWorkload start_workload(LshapeScheme scheme, int base_cells) {
  LshapeRunOptions options;
  options.problem.cells_per_edge = base_cells;
  options.directional.theta = 0.3;  // the study's
  LshapeProblem lshape = lshape_problem(options.problem);
  return {
      scheme, options, {lshape.material, lshape.supports, lshape.loads, {}, options.solver}, std::move(lshape.forest),
      {},     {}};
}

/// The base mesh is the coarsest of the nested ones, so that multigrid has all levels.
StepWorkload uniform_step(int dofs) {
  int n = 8;
  while (uniform_dofs(n) < dofs) n += 4;
  if (uniform_dofs(n) != dofs) throw std::runtime_error("no uniform L-shape has " + std::to_string(dofs) + " dofs");
  int base = n / 2;
  while (base % 4 == 0 && base > 4) base /= 2;
  StepWorkload work = start_workload(LshapeScheme::uniform, base);
  for (int cells = base; cells < n / 2; cells *= 2) refine_uniformly(work.forest);
  work.before = solve_static(work.forest, work.problem, nullptr, work.factors);
  return work;
}

/// The sequence up to the mesh before the first that has as many dofs.
StepWorkload adaptive_step(LshapeScheme scheme, int dofs) {
  StepWorkload work = start_workload(scheme, LshapeOptions{}.cells_per_edge);
  work.before = solve_static(work.forest, work.problem, nullptr, work.factors);
  for (;;) {
    const Mesh& mesh = work.before.discretization.mesh;
    RefinementForest refined = work.forest;
    if (apply_refinements(refined, mesh, choose_refinements(scheme, work.options, work.before)) == 0)
      throw std::runtime_error("the sequence ended before it had " + std::to_string(dofs) + " dofs");
    StaticSolution next = solve_static(refined, work.problem, &work.before, work.factors);
    if (next.discretization.dof_count() >= dofs) return work;
    work.forest = std::move(refined);
    work.before = std::move(next);
  }
}

StepWorkload& step_workload(LshapeScheme scheme, int dofs) {
  static std::map<std::pair<LshapeScheme, int>, std::unique_ptr<StepWorkload>> known;
  std::unique_ptr<StepWorkload>& work = known[{scheme, dofs}];
  if (!work) {
    use_one_thread();
    work = std::make_unique<StepWorkload>(scheme == LshapeScheme::uniform ? uniform_step(dofs)
                                                                          : adaptive_step(scheme, dofs));
  }
  return *work;
}

/// Mesh > T > patterns > levels > loads > equilibrium, and no estimate.
StaticSolution solve_without_estimate(const RefinementForest& forest, StepWorkload& work) {
  StaticSolution solution;
  solution.discretization = discretize(forest, work.problem.material, work.problem.supports);
  const Discretization& d = solution.discretization;
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, work.problem.supports);
  solution.equilibrium =
      solve_equilibrium(d, hierarchy, nodal_loads(forest.base(), d.mesh, work.problem.loads),
                        Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()), work.problem.solver, &work.factors);
  return solution;
}

void whole_static_frame(benchmark::State& state, LshapeScheme scheme) {
  StepWorkload& work = step_workload(scheme, static_cast<int>(state.range(0)));
  const Mesh& mesh = work.before.discretization.mesh;
  RefinementForest forest = work.forest;
  StaticSolution solution;
  for (auto _ : state) {
    state.PauseTiming();
    forest = work.forest;
    state.ResumeTiming();
    if (scheme == LshapeScheme::uniform) {
      refine_uniformly(forest);
      solution = solve_without_estimate(forest, work);
    } else {
      apply_refinements(forest, mesh, choose_refinements(scheme, work.options, work.before));
      solution = solve_static(forest, work.problem, &work.before, work.factors);
    }
    benchmark::ClobberMemory();
  }
  if (scheme == LshapeScheme::uniform)
    solution.estimate = estimate_error(solution.discretization, solution.equilibrium.u, work.problem.estimator);
  // Each mesh contains the one before, so its energy is larger, and smaller than the exact one: a solve that is wrong
  // anywhere falls out of the interval, which ends 1 to 6 % above.
  const double energy = solution.equilibrium.energy;
  if (solution.discretization.dof_count() < state.range(0))
    state.SkipWithError("the mesh is smaller than it was asked");
  if (!(solution.equilibrium.converged && energy > work.before.equilibrium.energy && energy < exact_energy()))
    state.SkipWithError("the energy is not between that of the mesh before and the exact one");
  count_sizes(state, solution.discretization);
  state.counters["iterations"] = solution.equilibrium.linear_iterations;
  state.counters["eta"] = solution.estimate.relative;
  state.counters["true_error"] = std::sqrt(1.0 - energy / exact_energy());
}

/// Dofs: of the uniform mesh, exactly; the mesh of a sequence is the first with as many. Both count prescribed ones.
constexpr auto uniform_sizes = [](auto* registered) {
  registered->ArgName("dofs")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  for (const int dofs : {975, 2793, 6075, 18759, 42483}) registered->Arg(dofs);
};
constexpr auto adaptive_sizes = [](auto* registered) {
  registered->ArgName("dofs")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  for (const int dofs : {1200, 5000, 12000, 30000}) registered->Arg(dofs);
};
constexpr auto directional_sizes = [](auto* registered) {
  registered->ArgName("dofs")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  for (const int dofs : {1200, 3000, 6000, 12000, 30000}) registered->Arg(dofs);
};
BENCHMARK_CAPTURE(whole_static_frame, full, LshapeScheme::uniform)->Apply(uniform_sizes);
BENCHMARK_CAPTURE(whole_static_frame, local, LshapeScheme::adaptive)->Apply(adaptive_sizes);
BENCHMARK_CAPTURE(whole_static_frame, directional, LshapeScheme::directional)->Apply(directional_sizes);

}  // namespace
