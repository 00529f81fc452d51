#include "core/adapt/tolerance_marking.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"

using namespace finegauge;

namespace {

RefinementForest row_of(int cells) {
  BoxMeshOptions options;
  options.cells = {cells, 1, 1};
  options.size = Eigen::Vector3d(cells, 1.0, 1.0);
  return RefinementForest(box_mesh(options));
}

/// η_e² per cell, energy 1 J; errors shared equally by the axes.
ErrorEstimate estimate_of(const std::vector<double>& squares, double energy = 1.0) {
  ErrorEstimate estimate;
  const auto n = static_cast<Eigen::Index>(squares.size());
  estimate.eta.resize(n);
  estimate.direction.setConstant(3, n, 1.0 / 3.0);
  double sum = 0.0;
  for (Eigen::Index cell = 0; cell < n; ++cell) {
    estimate.eta[cell] = std::sqrt(squares[cell]);
    sum += squares[cell];
  }
  estimate.total = std::sqrt(sum);
  estimate.energy_norm = std::sqrt(energy);
  estimate.relative = estimate.total / estimate.energy_norm;
  return estimate;
}

/// The sum of squares after the marked refinements, by the prediction.
double predicted(const ErrorEstimate& estimate, const std::vector<Refinement>& refine) {
  double sum = estimate.eta.squaredNorm();
  for (const Refinement& r : refine) {
    const double now = estimate.eta[r.cell] * estimate.eta[r.cell];
    sum += refined_error(now, estimate.direction.col(r.cell), r.refinement) - now;
  }
  return sum;
}

std::vector<double> random_squares(int count, std::mt19937& generator) {
  std::uniform_real_distribution<double> exponent(-4.0, 0.0);
  std::vector<double> squares;
  for (int i = 0; i < count; ++i) squares.push_back(std::pow(10.0, exponent(generator)));
  return squares;
}

}  // namespace

TEST_CASE("the leading error of a smooth field falls with the squares of the divisions", "[tolerance]") {
  // A stress that is linear along each axis, and constant in each cell of a trilinear field's recovery: the integral of
  // (slope x)² over a cell of length h is slope² h² / 12 of its volume.
  const Eigen::Vector3d slope(3.0, 1.0, 0.5);
  const auto error = [&](const Eigen::Vector3d& h) { return h.prod() * slope.cwiseProduct(h).squaredNorm() / 12.0; };
  for (const std::array<std::uint8_t, 3> n :
       {std::array<std::uint8_t, 3>{2, 2, 2}, {3, 3, 3}, {2, 3, 3}, {2, 1, 1}, {1, 4, 2}}) {
    const RefinementTemplate refinement{n};
    CAPTURE(to_string(refinement));
    const Eigen::Vector3d H(0.5, 0.7, 0.9), h = H.cwiseQuotient(Eigen::Vector3d(n[0], n[1], n[2]));
    const auto direction = [&](const Eigen::Vector3d& size) {
      return Eigen::Vector3d(slope.cwiseProduct(size).cwiseAbs2() / slope.cwiseProduct(size).squaredNorm());
    };
    const double children = refinement.child_count() * error(h);
    CHECK_THAT(refined_error(error(H), direction(H), refinement), WithinRel(children, 1e-13));
    CHECK_THAT(coarsened_error(children, direction(h), refinement), WithinRel(error(H), 1e-13));
  }
}

TEST_CASE("the fewest cells that bring the error to its level are refined, whatever their stress does", "[tolerance]") {
  const RefinementForest forest = row_of(10);
  const Mesh mesh = forest.leaf_mesh();
  std::mt19937 generator(3);
  const FrameAdaptRules rules{.tolerance = 0.5, .refine_at = 0.9, .coarsen_at = 0.7};
  int some = 0;
  for (int repetition = 0; repetition < 40; ++repetition) {
    CAPTURE(repetition);
    const std::vector<double> squares = random_squares(10, generator);
    double sum = 0.0;
    for (const double square : squares) sum += square;
    // η between a half and twice the tolerance
    const double ratio = 0.5 + 1.5 * repetition / 39.0, energy = sum / (0.25 * ratio * ratio);
    const ErrorEstimate estimate = estimate_of(squares, energy);
    const auto candidates = refinement_candidates(forest, mesh, estimate, rules);
    REQUIRE(candidates.size() == 10);
    const ToleranceLevels levels = tolerance_levels(estimate, candidates, rules);
    const auto refine = refine_to_tolerance(estimate, levels, candidates, rules);
    const double allowed = 0.25 * energy;
    CHECK(refine.empty() == (sum <= levels.refine_above));
    // A quarter of the square is left by the refinement of all: the tolerance is in reach up to twice it.
    CHECK(levels.reachable == (0.25 * sum <= allowed * (1.0 + 1e-9)));
    CHECK(levels.refine_above >= 0.81 * allowed * (1.0 - 1e-12));
    CHECK(levels.refine_above <= allowed * (1.0 + 1e-9));
    CHECK(levels.coarsen_up_to >= 0.49 * allowed * (1.0 - 1e-12));
    CHECK(levels.coarsen_up_to <= 0.9 * levels.refine_above * (1.0 + 1e-12));
    if (refine.empty()) continue;
    CHECK(predicted(estimate, refine) <= levels.refine_to * (1.0 + 1e-9));
    // By brute force: no smaller set does.
    std::size_t fewest = 10;
    for (unsigned set = 0; set < 1024; ++set) {
      std::vector<Refinement> chosen;
      for (int cell = 0; cell < 10; ++cell)
        if (set >> cell & 1u) chosen.push_back({cell, {}});
      if (predicted(estimate, chosen) <= levels.refine_to * (1.0 + 1e-9)) fewest = std::min(fewest, chosen.size());
    }
    CHECK(refine.size() == fewest);
    some += refine.size() < 10;
  }
  CHECK(some > 10);
}

TEST_CASE("where the depth limit holds the tolerance out of reach, cells without weight are left alone",
          "[tolerance]") {
  RefinementForest forest = row_of(9);
  forest.refine(0, {});
  const Mesh mesh = forest.leaf_mesh();
  REQUIRE(mesh.cell_count() == 16);
  // Eight cells as deep as they may be with an error of 1 J, one that counts, seven that hardly do.
  std::vector<double> squares(16, 1e-3);
  std::fill_n(squares.begin(), 8, 0.125);
  REQUIRE(mesh.frames[0].depth == 1);
  squares[8] = 0.5;
  const ErrorEstimate estimate = estimate_of(squares);
  const FrameAdaptRules rules{.tolerance = 0.5, .max_depth = 1};
  const auto candidates = refinement_candidates(forest, mesh, estimate, rules);
  CHECK(candidates.size() == 8);
  const ToleranceLevels levels = tolerance_levels(estimate, candidates, rules);
  CHECK_FALSE(levels.reachable);
  const auto refine = refine_to_tolerance(estimate, levels, candidates, rules);
  REQUIRE(refine.size() == 1);
  CHECK(refine.front().cell == 8);
  // The same with room for all of them.
  const FrameAdaptRules deeper{.tolerance = 0.5, .max_depth = 2};
  const auto all = refinement_candidates(forest, mesh, estimate, deeper);
  CHECK(all.size() == 16);
  CHECK(refine_to_tolerance(estimate, tolerance_levels(estimate, all, deeper), all, deeper).size() >= 8);
}

TEST_CASE("at the edge of reach the levels do not jump", "[tolerance]") {
  RefinementForest forest = row_of(4);
  forest.refine(0, {});
  const Mesh mesh = forest.leaf_mesh();
  std::vector<double> squares(11, 0.1);
  const auto levels_at = [&](double tolerance) {
    const ErrorEstimate estimate = estimate_of(squares);
    const FrameAdaptRules rules{.tolerance = tolerance, .max_depth = 1};
    const auto candidates = refinement_candidates(forest, mesh, estimate, rules);
    return tolerance_levels(estimate, candidates, rules);
  };
  const double left = 0.8 + 0.3 / 4.0;
  const ToleranceLevels below = levels_at(std::sqrt(left * (1.0 - 1e-6))),
                        above = levels_at(std::sqrt(left * (1.0 + 1e-6)));
  REQUIRE_FALSE(below.reachable);
  REQUIRE(above.reachable);
  CHECK_THAT(below.refine_to, WithinRel(above.refine_to, 1e-5));
  CHECK_THAT(below.refine_above, WithinRel(above.refine_above, 1e-5));
  CHECK_THAT(below.refine_to, WithinRel(left, 1e-5));
  CHECK(above.coarsen_up_to < left);  // nothing goes on either side
  CHECK(below.coarsen_up_to < left * (1.0 + 1e-5));
  for (const double tolerance : {0.5, 0.8, 0.93}) {
    const ToleranceLevels levels = levels_at(tolerance);
    CAPTURE(tolerance);
    CHECK(levels.refine_to <= 1.2 * left * (1.0 + 1e-12));
    CHECK(levels.refine_to >= left);
    CHECK(levels.coarsen_up_to < levels.refine_to);
  }
}

TEST_CASE("families go as long as the error predicted after it stays below its level, the least of them first",
          "[tolerance]") {
  RefinementForest forest = row_of(6);
  for (int cell = 0; cell < 5; ++cell) forest.refine(cell, {});
  const Mesh mesh = forest.leaf_mesh();
  REQUIRE(mesh.cell_count() == 41);
  // Family k has 0.001 · 2^k, its parent four times that; the last cell has 0.1.
  std::vector<double> squares;
  for (int family = 0; family < 5; ++family) squares.insert(squares.end(), 8, 0.001 * (1 << family) / 8.0);
  squares.push_back(0.1);
  const ErrorEstimate estimate = estimate_of(squares);
  FrameAdaptHistory history;
  history.changed.assign(static_cast<std::size_t>(forest.handle_count()), FrameAdaptHistory::long_ago);
  std::vector<std::uint8_t> marked(41, 0);
  const auto coarsened = [&](const FrameAdaptRules& rules, int frame = 0) {
    const auto candidates = refinement_candidates(forest, mesh, estimate, rules);
    return coarsen_within_tolerance(forest, mesh, estimate, tolerance_levels(estimate, candidates, rules), marked,
                                    frame, rules, history);
  };
  // Now 0.131; families 0 to k go where 0.131 + 0.003 (2^(k+1) - 1) is at most (0.7 tolerance)².
  const auto tolerance_for = [](double square) { return std::sqrt(square) / 0.7; };
  const auto rules_for = [&](double square) { return FrameAdaptRules{.tolerance = tolerance_for(square)}; };
  CHECK(coarsened(rules_for(0.1339)).empty());
  CHECK(coarsened(rules_for(0.1341)) == std::vector{0});
  CHECK(coarsened(rules_for(0.1399)) == std::vector{0});
  CHECK(coarsened(rules_for(0.1401)) == std::vector{0, 1});
  CHECK(coarsened(rules_for(0.2239)) == std::vector{0, 1, 2, 3});
  CHECK(coarsened(rules_for(0.2241)) == std::vector{0, 1, 2, 3, 4});
  // One marked cell or a young one holds its family, and the others go on.
  marked[3] = 1;
  CHECK(coarsened(rules_for(0.1401)) == std::vector{1});
  marked[3] = 0;
  history.changed[mesh.forest_cell[9]] = 5;
  CHECK(coarsened(rules_for(0.1401), 14) == std::vector{0});
  CHECK(coarsened(rules_for(0.1401), 15) == std::vector{0, 1});
  // A local tolerance is the parent's own: 0.7² of its square times the energy against 0.004 · 2^k.
  const FrameAdaptRules local{.local_tolerance = std::sqrt(0.0081) / 0.7};
  CHECK(coarsened(local, 100) == std::vector{0, 1});
}

namespace {

/// A spot of error that wanders along a row of cells and dies: the model of a needle in a body.
struct SpotRun {
  int asked = 0, met = 0, toggles = 0, most_cells = 0, both = 0;
  double cell_frames = 0.0, worst = 0.0;
  std::vector<FrameMarks> marks;
  Mesh last;
};

SpotRun wandering_spot(const FrameAdaptRules& rules, double energy_scale = 1.0) {
  BoxMeshOptions options;
  options.cells = {16, 4, 4};
  options.size = {16.0, 4.0, 4.0};
  RefinementForest forest(box_mesh(options));
  FrameAdaptHistory history;
  SpotRun run;
  for (int frame = 0; frame < 400; ++frame) {
    const Mesh mesh = forest.leaf_mesh();
    const Eigen::Vector3d spot(-2.0 + 0.055 * frame, 1.9, 2.1);
    const double strength = frame < 360 ? 1.0 : std::pow(0.5, frame - 360);
    ErrorEstimate estimate;
    estimate.eta.resize(mesh.cell_count());
    estimate.direction.setConstant(3, mesh.cell_count(), 1.0 / 3.0);
    Eigen::VectorXd stress(mesh.cell_count());
    double total = 0.0, energy = 0.0;
    for (int cell = 0; cell < mesh.cell_count(); ++cell) {
      const Eigen::Vector3d lower = mesh.nodes.col(mesh.cells[cell][0]), upper = mesh.nodes.col(mesh.cells[cell][7]);
      const double h = (upper - lower)[0], volume = (upper - lower).prod();
      const double sigma = 0.2 + std::exp(-(0.5 * (lower + upper) - spot).squaredNorm());
      stress[cell] = strength * sigma;
      const double error = energy_scale * strength * strength * volume * 0.04 * h * h * (sigma - 0.19) * (sigma - 0.19);
      energy += energy_scale * strength * strength * volume * sigma * sigma;
      total += error;
      estimate.eta[cell] = std::sqrt(error);
    }
    estimate.total = std::sqrt(total);
    estimate.energy_norm = std::sqrt(energy);
    estimate.relative = estimate.total / estimate.energy_norm;
    const bool at_rest = energy < rules.energy_floor;
    run.asked += !at_rest;
    const double ratio = tolerance_ratio(estimate, rules);
    run.met += !at_rest && ratio <= 1.0;
    if (!at_rest) run.worst = std::max(run.worst, ratio);
    FrameMarks marks = mark_frame(forest, mesh, estimate, stress, frame, 0, rules, history);
    run.both += !marks.refine.empty() && !marks.coarsen.empty();
    static_cast<void>(adapt_forest(mesh, marks, frame, forest, history));
    REQUIRE(validate(forest).empty());
    run.cell_frames += mesh.cell_count();
    run.most_cells = std::max(run.most_cells, mesh.cell_count());
    run.marks.push_back(std::move(marks));
  }
  run.toggles = history.toggles;
  run.last = forest.leaf_mesh();
  return run;
}

}  // namespace

TEST_CASE("a tolerance is held while the error wanders, and the mesh comes back", "[tolerance][frame]") {
  const bool global = GENERATE(true, false);
  CAPTURE(global);
  FrameAdaptRules rules{.energy_floor = 1e-6, .dwell = 10, .max_depth = 2};
  (global ? rules.tolerance : rules.local_tolerance) = global ? 0.05 : 0.02;
  const SpotRun run = wandering_spot(rules);
  FrameAdaptRules none = rules;
  none.max_depth = 0;
  const SpotRun unrefined = wandering_spot(none);
  REQUIRE(unrefined.met < unrefined.asked / 2);  // otherwise there is nothing to hold
  REQUIRE(unrefined.worst > 1.5);
  REQUIRE(run.asked > 350);
  CHECK(run.met >= 0.98 * run.asked);
  CHECK(run.worst < unrefined.worst);
  CHECK(run.most_cells > 256);
  CHECK(run.most_cells < 256 * 8);  // not all of them
  CHECK(run.last.cell_count() == 256);
  CHECK(same_bits(run.last, unrefined.last, true));
  // 0.05 toggles per cell and second at 200 frames a second.
  CHECK(run.toggles / run.cell_frames <= 0.05 / 200.0);
}

TEST_CASE("in units scaled by powers of two the same cells are marked under a tolerance", "[tolerance][determinism]") {
  FrameAdaptRules rules{.tolerance = 0.05, .energy_floor = 1e-6, .max_depth = 2};
  const SpotRun one = wandering_spot(rules);
  const int exponent = GENERATE(1, -7, 12);
  rules.energy_floor = std::ldexp(rules.energy_floor, exponent);
  const SpotRun other = wandering_spot(rules, std::ldexp(1.0, exponent));
  bool same = one.marks.size() == other.marks.size();
  for (std::size_t k = 0; same && k < one.marks.size(); ++k) {
    same = one.marks[k].coarsen == other.marks[k].coarsen && one.marks[k].refine.size() == other.marks[k].refine.size();
    for (std::size_t i = 0; same && i < one.marks[k].refine.size(); ++i)
      same = one.marks[k].refine[i].cell == other.marks[k].refine[i].cell;
  }
  CHECK(same);
}

TEST_CASE("a frame that misses its tolerance says what holds it", "[tolerance]") {
  const RefinementForest forest = row_of(4);
  const Mesh mesh = forest.leaf_mesh();
  const Eigen::VectorXd stress = Eigen::VectorXd::Ones(4);
  const ErrorEstimate estimate = estimate_of(std::vector<double>(4, 0.01));  // η = 0.2
  const auto limit = [&](FrameAdaptRules rules) {
    FrameAdaptHistory history;
    return mark_frame(forest, mesh, estimate, stress, 0, 60, rules, history).limit;
  };
  CHECK(limit({.tolerance = 0.15}) == AdaptLimit::none);  // 0.1 is in reach
  CHECK(limit({.tolerance = 0.09}) == AdaptLimit::depth);
  CHECK(limit({.tolerance = 0.15, .max_depth = 0}) == AdaptLimit::depth);
  CHECK(limit({.tolerance = 0.15, .max_dofs = 61}) == AdaptLimit::dofs);
  CHECK(limit({.tolerance = 0.21, .max_depth = 0}) == AdaptLimit::none);  // met
  CHECK(limit({.local_tolerance = 0.09, .max_depth = 0}) == AdaptLimit::depth);
  CHECK(limit({.local_tolerance = 0.09}) == AdaptLimit::none);
  CHECK(limit({.max_depth = 0}) == AdaptLimit::none);  // none asked
}
