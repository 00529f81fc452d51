#include "benchmarks/paper/tjunctions_cases.hpp"

#include <algorithm>
#include <cmath>

#include "benchmarks/profile/processor_clock.hpp"

namespace finegauge {
namespace {

constexpr TjunctionHandling all_handlings[] = {TjunctionHandling::elementwise, TjunctionHandling::explicit_product,
                                               TjunctionHandling::multiplier, TjunctionHandling::ignored};

/// Moduli play no part in what is counted; corotational, so that an assembly costs what it costs in a frame.
Material cube_material() {
  Material material;
  material.youngs_modulus = 1e3;
  material.poisson_ratio = 0.3;
  material.kinematics = Kinematics::corotational;
  return material;
}

/// Median over discretizations that are thrown away, and one that is kept.
Discretization timed_discretization(const RefinementForest& forest, int repetitions, double& ms) {
  std::vector<double> times;
  Discretization d;
  for (int repetition = 0; repetition < std::max(3, repetitions); ++repetition) {
    Stopwatch watch(processor_clock());
    d = discretize(forest, cube_material(), cube_supports());
    times.push_back(watch.lap());
  }
  ms = median_ms(times);
  return d;
}

}  // namespace

std::vector<TjunctionCase> tjunction_cases(StudySize size) {
  std::vector<TjunctionCase> cases;
  const auto add = [&](const std::string& sweep, MarkedCube cube, bool counts_only = false) {
    for (const MarkingPattern pattern : marking_patterns) {
      cube.pattern = pattern;
      cases.push_back({sweep, cube, counts_only});
    }
  };
  const auto choose = [&](int quick, int usual, int full) {
    return size == StudySize::quick ? quick : size == StudySize::usual ? usual : full;
  };
  const RefinementTemplate halves{{2, 2, 2}}, mixed{{2, 3, 3}}, thirds{{3, 3, 3}};
  for (const double share : {0.01, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75})
    if (size != StudySize::quick || share == 0.02 || share == 0.1 || share == 0.5)
      add("share", {choose(5, 6, 8), MarkingPattern::block, share, halves, 1, 1});
  for (const RefinementTemplate& refinement : {halves, mixed, thirds})
    add("template", {choose(4, 5, 6), MarkingPattern::block, 0.1, refinement, 1, 1});
  for (const int cells : {4, 6, 8, 10})
    add("mesh", {cells, MarkingPattern::block, 0.1, halves, 1, 1}, cells > choose(4, 8, 10));
  for (const int cells : {16, 24}) add("mesh", {cells, MarkingPattern::block, 0.1, halves, 1, 1}, true);
  for (const int levels : {1, 2, 3})
    if (size != StudySize::quick || levels == 2)
      add("levels", {choose(4, 5, 6), MarkingPattern::block, 0.2, halves, levels, 1});
  return cases;
}

double TjunctionCaseResult::saved_ms() const {
  const auto solve_ms = [&](TjunctionHandling handling) {
    const HandlingCost& cost = costs.at(handling);
    return cost.symbolic_ms + cost.numeric_ms + cost.solve_ms;
  };
  return solve_ms(TjunctionHandling::ignored) - solve_ms(TjunctionHandling::elementwise);
}

double TjunctionCaseResult::explicit_over_elementwise() const {
  return costs.at(TjunctionHandling::explicit_product).matrix_ms() /
         costs.at(TjunctionHandling::elementwise).matrix_ms();
}

TjunctionCaseResult run_case(const TjunctionCase& asked, int repetitions) {
  TjunctionCaseResult result;
  result.asked = asked;
  const RefinementForest forest = refined_forest(asked.cube);
  int refined = 0;
  const int base_cells = static_cast<int>(forest.base().cells.size());
  for (int cell = 0; cell < base_cells; ++cell) refined += !forest.is_leaf(cell);
  result.refined_share = static_cast<double>(refined) / base_cells;
  const Discretization d = timed_discretization(forest, repetitions, result.discretize_ms);
  result.counts = count_tjunctions(forest, d);
  const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  result.times = time_tjunctions(forest, d, rest, std::max(5, repetitions));
  if (asked.counts_only) return result;
  HandlingOptions options;
  options.repetitions = repetitions;
  const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, cube_loads());
  for (HandlingCost& cost :
       compare_handlings(d, rest, loads, {std::begin(all_handlings), std::end(all_handlings)}, options))
    result.costs.emplace(cost.handling, std::move(cost));
  return result;
}

ConformingCube run_conforming(int cells_per_edge, RefinementTemplate refinement, int repetitions) {
  const RefinementForest forest = refined_forest({cells_per_edge, MarkingPattern::block, 1.0, refinement, 1, 1});
  ConformingCube cube;
  cube.cells_per_edge = cells_per_edge, cube.refinement = refinement;
  double discretize_ms = 0.0;
  const Discretization d = timed_discretization(forest, repetitions, discretize_ms);
  HandlingOptions options;
  options.repetitions = repetitions, options.iterate = false;
  const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  const HandlingCost cost = compare_handlings(d, rest, nodal_loads(forest.base(), d.mesh, cube_loads()),
                                              {TjunctionHandling::elementwise}, options)
                                .front();
  cube.dofs = d.dof_count();
  cube.whole_ms = discretize_ms + cost.total_ms(), cube.factor_nonzeros = cost.factor_nonzeros;
  return cube;
}

std::optional<double> share_that_costs_the_whole(const std::vector<const TjunctionCaseResult*>& results,
                                                 double whole_ms) {
  for (std::size_t k = 1; k < results.size(); ++k) {
    const double a = results[k - 1]->whole_ms() / whole_ms, b = results[k]->whole_ms() / whole_ms;
    if (!(a < 1.0 && b >= 1.0)) continue;
    const double w = std::log(1.0 / a) / std::log(b / a);
    return std::exp((1.0 - w) * std::log(results[k - 1]->refined_share) + w * std::log(results[k]->refined_share));
  }
  return std::nullopt;
}

Json to_json(const TjunctionCaseResult& result) {
  const MarkedCube& cube = result.asked.cube;
  Json row = {{"kind", "cube"},
              {"sweep", result.asked.sweep},
              {"pattern", to_string(cube.pattern)},
              {"template", to_string(cube.refinement)},
              {"cells_per_edge", cube.cells_per_edge},
              {"levels", cube.levels},
              {"refined_share", result.refined_share}};
  row.update(to_json(result.counts));
  row["discretize_ms"] = result.discretize_ms;
  row["build_ms"] = result.times.build_ms, row["reduce_ms"] = result.times.reduce_ms;
  row["expand_ms"] = result.times.expand_ms, row["gather_ms"] = result.times.gather_ms;
  if (result.costs.empty()) {
    row["elementwise"] = nullptr;
    row["elementwise_reason"] = "counted only: too large to be factored in four ways";
    return row;
  }
  for (const TjunctionHandling handling : all_handlings) row[to_string(handling)] = to_json(result.costs.at(handling));
  row["explicit_over_elementwise"] = result.explicit_over_elementwise();
  row["overhead_ms"] = result.overhead_ms();
  row["saved_ms"] = result.saved_ms();
  return row;
}

}  // namespace finegauge
