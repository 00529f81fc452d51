#include "core/adapt/frame_adaptivity.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <stdexcept>

#include "core/space/discretization.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"

using namespace finegauge;

namespace {

BaseMesh box(std::array<int, 3> cells, CellShape shape = CellShape::hexahedron) {
  BoxMeshOptions options;
  options.cells = cells;
  options.size = Eigen::Vector3d(cells[0], cells[1], cells[2]);
  options.shape = shape;
  return box_mesh(options);
}

/// Error and stress of one leaf, as a solution would give them.
struct LeafField {
  double eta_squared, von_mises;
  Eigen::Vector3d direction = Eigen::Vector3d::Constant(1.0 / 3.0);
};

struct Fields {
  ErrorEstimate estimate;
  Eigen::VectorXd von_mises;
};

/// `energy` is ∫ ε:σ; all energies are scaled by `energy_scale` before η is the root, as a change of units would.
Fields fields(const Mesh& mesh, double energy, const std::function<LeafField(int)>& leaf, double energy_scale = 1.0,
              double stress_scale = 1.0) {
  Fields f;
  f.estimate.eta.resize(mesh.cell_count());
  f.estimate.direction.resize(3, mesh.cell_count());
  f.von_mises.resize(mesh.cell_count());
  double total = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const LeafField field = leaf(cell);
    f.estimate.eta[cell] = std::sqrt(energy_scale * field.eta_squared);
    f.estimate.direction.col(cell) = field.direction;
    f.von_mises[cell] = stress_scale * field.von_mises;
    total += energy_scale * field.eta_squared;
  }
  f.estimate.total = std::sqrt(total);
  f.estimate.energy_norm = std::sqrt(energy_scale * energy);
  f.estimate.relative = energy > 0.0 ? f.estimate.total / f.estimate.energy_norm : 0.0;
  return f;
}

Eigen::Vector3d centre(const Mesh& mesh, int cell) {
  const int corners = corner_count(mesh.shape);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int c = 0; c < corners; ++c) sum += mesh.nodes.col(mesh.cells[cell][c]);
  return sum / corners;
}

Eigen::Vector3d size(const Mesh& mesh, int cell) {
  return mesh.nodes.col(mesh.cells[cell][7]) - mesh.nodes.col(mesh.cells[cell][0]);
}

bool history_follows(const FrameAdaptHistory& history, const RefinementForest& forest) {
  const auto handles = static_cast<std::size_t>(forest.handle_count());
  if (history.von_mises.size() != handles || history.changed.size() != handles || history.coarsened.size() != handles)
    return false;
  std::vector<std::uint8_t> leaf(handles, 0);
  for (const int handle : leaves(forest)) leaf[handle] = 1;
  for (std::size_t handle = 0; handle < handles; ++handle)
    if (!leaf[handle] && (history.von_mises[handle] >= 0.0 || history.coarsened[handle] ||
                          history.changed[handle] != FrameAdaptHistory::long_ago))
      return false;
  return true;
}

bool same(const FrameMarks& a, const FrameMarks& b) {
  return a.coarsen == b.coarsen &&
         std::equal(a.refine.begin(), a.refine.end(), b.refine.begin(), b.refine.end(),
                    [](const auto& p, const auto& q) { return p.cell == q.cell && p.refinement == q.refinement; });
}

/// The marks of a second frame on a forest in which every cell has a stress of 1 Pa from the first.
FrameMarks marks_after_one_frame(const RefinementForest& forest, const Fields& f, const FrameAdaptRules& rules,
                                 int dofs = 0) {
  FrameAdaptHistory history;
  const Mesh mesh = forest.leaf_mesh();
  Fields before = f;
  before.von_mises.setOnes();
  static_cast<void>(mark_frame(forest, mesh, before.estimate, before.von_mises, 0, dofs, rules, history));
  return mark_frame(forest, mesh, f.estimate, f.von_mises, rules.every, dofs, rules, history);
}

/// Two cells: the error of cell 0 and all that comes of it is `series`(frame) of that of cell 1, which rests.
struct Oscillation {
  std::vector<int> refined, coarsened, toggled;  ///< frames
};
Oscillation oscillate(const FrameAdaptRules& rules, int frames, double low, double high) {
  RefinementForest forest(box({2, 1, 1}));
  FrameAdaptHistory history;
  Oscillation result;
  for (int frame = 0; frame < frames; ++frame) {
    const Mesh mesh = forest.leaf_mesh();
    const double value = frame % 2 ? high : low;
    const Fields f = fields(mesh, 1.0, [&](int cell) {
      if (mesh.frames[cell].base_cell == 1) return LeafField{1.0, 1.0};
      return LeafField{value * value * size(mesh, cell).prod(), value};
    });
    const int toggles = history.toggles;
    const FrameMarks marks = mark_frame(forest, mesh, f.estimate, f.von_mises, frame, 0, rules, history);
    const FrameChange change = adapt_forest(mesh, marks, frame, forest, history);
    if (change.refined) result.refined.push_back(frame);
    if (change.coarsened) result.coarsened.push_back(frame);
    if (history.toggles > toggles) result.toggled.push_back(frame);
  }
  return result;
}

}  // namespace

TEST_CASE("with one threshold and no dwell an error near it changes the mesh in every frame", "[adapt][hysteresis]") {
  // What the two tests below would see if the rules did nothing.
  const auto run = oscillate({.refine_above = 0.3, .coarsen_below = 0.3, .dwell = 0}, 200, 0.28, 0.32);
  CHECK(run.refined.size() == 100);   // all odd frames
  CHECK(run.coarsened.size() == 99);  // all even ones but the first
  CHECK(run.toggled.size() == 198);
}

TEST_CASE("an error that swings about one of two thresholds changes the mesh once", "[adapt][hysteresis]") {
  const auto about_refining = oscillate({.refine_above = 0.3, .coarsen_below = 0.05, .dwell = 0}, 200, 0.28, 0.32);
  CHECK(about_refining.refined == std::vector{1});
  CHECK(about_refining.coarsened.empty());
  const auto about_coarsening = oscillate({.refine_above = 0.3, .coarsen_below = 0.05, .dwell = 0}, 200, 0.045, 0.055);
  CHECK(about_coarsening.refined.empty());
}

TEST_CASE("an error that swings across both thresholds toggles once in a dwell time", "[adapt][hysteresis]") {
  const int dwell = GENERATE(1, 4, 10, 11);
  CAPTURE(dwell);
  const auto run = oscillate({.refine_above = 0.3, .coarsen_below = 0.05, .dwell = dwell}, 200, 0.02, 0.5);
  // Refined in odd frames, coarsened in the first even one after the dwell time, refined again in the next.
  const int period = (dwell + 1) / 2 * 2 + (dwell % 2 ? 0 : 2);
  CHECK(static_cast<int>(run.refined.size()) == 1 + 198 / period);
  CHECK_FALSE(run.coarsened.empty());
  CHECK_FALSE(run.toggled.empty());
  for (std::size_t k = 1; k < run.coarsened.size(); ++k) CHECK(run.coarsened[k] - run.coarsened[k - 1] > dwell);
  if (dwell >= 10)  // the yardstick of history.toggle_window
    for (std::size_t k = 1; k < run.toggled.size(); ++k) CHECK(run.toggled[k] - run.toggled[k - 1] >= dwell);
}

namespace {

struct HotSpotRun {
  std::vector<FrameMarks> marks;
  std::set<int> columns;  ///< of base cells along the path, refined at some time
  int refined = 0, families = 0, coarsened = 0, refined_behind = 0, coarsened_ahead = 0, both_in_a_frame = 0,
      deepest = 0;
  Mesh last;
  FrameAdaptHistory history;
};

/// A division by 4 is two levels: the outer family and one in each of its cells.
int families_made(RefinementTemplate refinement) {
  int outer = 1;
  for (const int n : refinement.divisions) outer *= n == 4 ? 2 : n;
  return outer < refinement.child_count() ? 1 + outer : 1;
}

/// A spot that crosses a box of 12 × 6 × 6 cells of 1 m from end to end, 0.11 m in a frame, with a halo of 1.2 m.
HotSpotRun hot_spot(const FrameAdaptRules& rules, double energy_scale = 1.0, double stress_scale = 1.0) {
  RefinementForest forest(box({12, 6, 6}));
  HotSpotRun run;
  const double width = 1.2, step = 0.11;
  for (int frame = 0; frame < 210; ++frame) {
    const Eigen::Vector3d spot(-5.0 + step * frame, 3.1, 2.9);
    const Mesh mesh = forest.leaf_mesh();
    double energy = 0.0;
    const auto stress = [&](int cell) {
      return std::exp(-(centre(mesh, cell) - spot).squaredNorm() / (width * width));
    };
    for (int cell = 0; cell < mesh.cell_count(); ++cell)
      energy += size(mesh, cell).prod() * stress(cell) * stress(cell);
    const Fields f = fields(
        mesh, energy,
        [&](int cell) {
          // h² of the stress along each axis, times the stress: the leading error of a smooth field.
          const Eigen::Vector3d h = size(mesh, cell);
          const Eigen::Vector3d share = h.cwiseAbs2().cwiseProduct(Eigen::Vector3d(4.0, 1.0, 0.05));
          const double sigma = stress(cell);
          return LeafField{0.1 * h.prod() * share.sum() * sigma * sigma, sigma, share / share.sum()};
        },
        energy_scale, stress_scale);
    FrameMarks marks = mark_frame(forest, mesh, f.estimate, f.von_mises, frame, 0, rules, run.history);
    REQUIRE(std::is_sorted(marks.coarsen.begin(), marks.coarsen.end()));
    for (const Refinement& r : marks.refine) {
      if (mesh.frames[r.cell].depth > 0) continue;  // a new cell is compared with its parent's stress
      run.columns.insert(static_cast<int>(centre(mesh, r.cell)[0]));
      run.refined_behind += centre(mesh, r.cell)[0] < spot[0] - 0.5 * step;
    }
    for (int cell = 0; cell < mesh.cell_count(); ++cell)
      if (std::binary_search(marks.coarsen.begin(), marks.coarsen.end(), forest.cell(mesh.forest_cell[cell]).parent))
        run.coarsened_ahead += centre(mesh, cell)[0] > spot[0] - 0.5 * step;
    const FrameChange change = adapt_forest(mesh, marks, frame, forest, run.history);
    REQUIRE(validate(forest).empty());
    REQUIRE(history_follows(run.history, forest));
    for (const Refinement& r : marks.refine) run.families += families_made(r.refinement);
    run.refined += change.refined;
    run.coarsened += change.coarsened;
    run.both_in_a_frame += change.refined > 0 && change.coarsened > 0;
    for (const int leaf : leaves(forest)) run.deepest = std::max(run.deepest, forest.cell(leaf).depth);
    run.marks.push_back(std::move(marks));
  }
  run.last = forest.leaf_mesh();
  return run;
}

FrameAdaptRules hot_spot_rules(bool directional, RefinementTemplate refinement, int max_depth) {
  return {.refine_above = 0.3,
          .coarsen_below = 0.1,
          .energy_floor = 1e-5,
          .dwell = 5,
          .max_depth = max_depth,
          .directional = directional,
          .refinement = refinement};
}

}  // namespace

TEST_CASE("cells refine ahead of a moving spot, coarsen behind it, and leave the base mesh", "[adapt][frame]") {
  const bool directional = GENERATE(false, true);
  const RefinementTemplate refinement{GENERATE(std::array<std::uint8_t, 3>{2, 2, 2},
                                               std::array<std::uint8_t, 3>{3, 3, 3},
                                               std::array<std::uint8_t, 3>{2, 3, 3})};
  const int max_depth = GENERATE(1, 2);
  if (max_depth == 2 && refinement != RefinementTemplate{}) return;  // thousands of cells, nothing new
  CAPTURE(directional, to_string(refinement), max_depth);
  const HotSpotRun run = hot_spot(hot_spot_rules(directional, refinement, max_depth));
  CHECK(run.columns.size() == 12);  // the whole path was refined
  CHECK(run.deepest == max_depth);
  CHECK(run.both_in_a_frame > 0);
  CHECK(run.refined_behind == 0);
  CHECK(run.coarsened_ahead == 0);
  CHECK(run.coarsened == run.families);
  const RefinementForest base(box({12, 6, 6}));
  CHECK(same_bits(run.last, base.leaf_mesh(), true));
  CHECK(history_follows(run.history, base));
  bool along_one_axis_less = false;
  for (const FrameMarks& marks : run.marks)
    for (const Refinement& r : marks.refine) {
      const auto& n = r.refinement.divisions;
      along_one_axis_less |= *std::min_element(n.begin(), n.end()) == 1;
      // Thirds where the rule's template has one, and then no halves.
      if (directional) REQUIRE((*std::max_element(n.begin(), n.end()) == 3) == (refinement.divisions[2] == 3));
    }
  CHECK(along_one_axis_less == directional);
  CHECK((run.families > run.refined) == (directional && max_depth == 2));  // divisions by 4
}

TEST_CASE("the same frames give the same marks, and in other units too", "[adapt][frame][determinism]") {
  const FrameAdaptRules rules = hot_spot_rules(false, {}, 2);
  const HotSpotRun one = hot_spot(rules);
  const int exponent = GENERATE(0, 1, -7, 12);  // of the unit of energy; odd ones scale η by an irrational number
  CAPTURE(exponent);
  FrameAdaptRules scaled = rules;
  scaled.energy_floor = std::ldexp(rules.energy_floor, exponent);
  const HotSpotRun other = hot_spot(scaled, std::ldexp(1.0, exponent), std::ldexp(1.0, 3 * exponent));
  CHECK(std::equal(one.marks.begin(), one.marks.end(), other.marks.begin(), other.marks.end(), same));
  CHECK(one.history.toggles == other.history.toggles);
  CHECK(same_bits(one.last, other.last, true));
}

TEST_CASE("errors that tie with a threshold are marked in any unit", "[adapt][determinism]") {
  // θ² max η² is the error of every third base cell, and θ_c² max η² that of each of the refined ones.
  RefinementForest forest(box({100, 1, 1}));
  for (int base = 1; base < 100; base += 3) forest.refine(base, {});
  const Mesh mesh = forest.leaf_mesh();
  const FrameAdaptRules rules{.refine_above = 0.3, .coarsen_below = 0.1, .dwell = 0};
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> uniform(0.25, 1.0);
  int naive_losses = 0;
  for (const int exponent : {-29, -2, 0, 1, 3, 30})
    for (int repetition = 0; repetition < 20; ++repetition) {
      const double largest = uniform(generator);
      CAPTURE(exponent, largest);
      const Fields f = fields(
          mesh, 1.0,
          [&](int cell) {
            if (mesh.frames[cell].depth == 1) return LeafField{0.1 * 0.1 * largest / 8.0, 0.5};
            const int base = mesh.frames[cell].base_cell;
            return base == 0 ? LeafField{largest, 0.5} : LeafField{0.3 * 0.3 * largest, 2.0};
          },
          std::ldexp(1.0, exponent));
      const FrameMarks marks = marks_after_one_frame(forest, f, rules);
      CHECK(marks.refine.size() == 66);
      CHECK(marks.coarsen.size() == 33);
      const int tied = mesh.cell_count() - 1;  // of base cell 99
      naive_losses += f.estimate.eta[tied] < 0.3 * f.estimate.eta.maxCoeff();
    }
  CHECK(naive_losses > 0);  // of roots compared as they are
}

TEST_CASE("a refinement never exceeds the bounds on depth and dofs, and the worst cells come first",
          "[adapt][bounds]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const bool directional = GENERATE(false, true);
  const auto divisions = GENERATE(std::array<std::uint8_t, 3>{2, 2, 2}, std::array<std::uint8_t, 3>{3, 3, 3},
                                  std::array<std::uint8_t, 3>{4, 1, 2});
  if (shape == CellShape::tetrahedron && divisions != std::array<std::uint8_t, 3>{2, 2, 2}) return;
  const int max_depth = GENERATE(2, 3), max_dofs = GENERATE(700, 1500);
  CAPTURE(shape == CellShape::hexahedron, directional, to_string(RefinementTemplate{divisions}), max_depth, max_dofs);
  const FrameAdaptRules rules{.refine_above = 0.01,
                              .coarsen_below = 0.01,
                              .max_depth = max_depth,
                              .max_dofs = max_dofs,
                              .directional = directional,
                              .refinement = {divisions}};
  RefinementForest forest(box({3, 2, 2}, shape));
  FrameAdaptHistory history;
  std::mt19937 generator(20240607);
  std::uniform_real_distribution<double> uniform(0.1, 1.0);
  int dofs = 0, deepest = 0, largest_growth = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const Discretization d = discretize(forest, {}, {});
    largest_growth = std::max(largest_growth, d.dof_count() - dofs);
    dofs = d.dof_count();
    REQUIRE(dofs <= max_dofs);
    for (const LeafFrame& leaf : d.mesh.frames) deepest = std::max(deepest, leaf.depth);
    REQUIRE(deepest <= max_depth);
    const Fields f = fields(d.mesh, 1.0, [&](int) {
      const Eigen::Vector3d share(uniform(generator), uniform(generator), uniform(generator));
      return LeafField{uniform(generator), 1.0 + frame, share / share.sum()};
    });
    const FrameMarks marks = mark_frame(forest, d.mesh, f.estimate, f.von_mises, frame, dofs, rules, history);
    double worst_left = 0.0, least_marked = 1.0;
    std::vector<std::uint8_t> marked(static_cast<std::size_t>(d.mesh.cell_count()), 0);
    for (const Refinement& r : marks.refine) marked[r.cell] = 1;
    for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
      if (marked[cell]) least_marked = std::min(least_marked, f.estimate.eta[cell]);
      const int levels = divisions[0] == 4 && !directional ? 2 : 1;
      if (!marked[cell] && d.mesh.frames[cell].depth + levels <= max_depth)
        worst_left = std::max(worst_left, f.estimate.eta[cell]);
    }
    if (!directional && !marks.refine.empty()) CHECK(least_marked >= worst_left);
    static_cast<void>(adapt_forest(d.mesh, marks, frame, forest, history));
  }
  CHECK(largest_growth > 0);
  if (shape == CellShape::hexahedron) {
    // The budget is used but for less than the largest template's bound, or every leaf is as deep as it may be.
    const Mesh mesh = forest.leaf_mesh();
    const bool exhausted = std::all_of(mesh.frames.begin(), mesh.frames.end(), [&](const LeafFrame& leaf) {
      return leaf.depth + (divisions[0] == 4 && !directional ? 2 : 1) > max_depth;
    });
    CHECK((exhausted || dofs > max_dofs - 3 * (125 - 8)));
  }
  CHECK(deepest >= 1);
}

TEST_CASE("a lone cell is refined exactly if its new dofs fit", "[adapt][bounds]") {
  const RefinementForest forest(box({1, 1, 1}));
  const Fields f = fields(forest.leaf_mesh(), 1.0, [](int) { return LeafField{1.0, 2.0}; });
  for (const RefinementTemplate& refinement : all_templates()) {
    CAPTURE(to_string(refinement));
    RefinementForest refined = forest;
    refined.refine(0, refinement);
    const int dofs = discretize(refined, {}, {}).dof_count();
    const auto marked = [&](int max_dofs) {
      const FrameAdaptRules rules{.max_depth = 2, .max_dofs = max_dofs, .refinement = refinement};
      return marks_after_one_frame(forest, f, rules, 24).refine.size();
    };
    CHECK(marked(dofs) == 1);
    CHECK(marked(dofs - 1) == 0);
  }
}

TEST_CASE("the bound on dofs holds among templates of all kinds, while cells coarsen too", "[adapt][bounds]") {
  RefinementForest forest(box({2, 2, 2}));
  FrameAdaptHistory history;
  std::mt19937 generator(20240608);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto templates = all_templates();
  const int max_dofs = 2000;
  int refined = 0, coarsened = 0, most = 0;
  for (int frame = 0; frame < 150; ++frame) {
    const Discretization d = discretize(forest, {}, {});
    REQUIRE(d.dof_count() <= max_dofs);
    most = std::max(most, d.dof_count());
    const FrameAdaptRules rules{.refine_above = 0.5,
                                .coarsen_below = 0.4,
                                .dwell = 2,
                                .max_depth = 3,
                                .max_dofs = max_dofs,
                                .refinement = templates[generator() % templates.size()]};
    // Half of the base cells rise, the others fall.
    const Fields f = fields(d.mesh, 1.0, [&](int cell) {
      const bool rises = (d.mesh.frames[cell].base_cell + frame / 10) % 2 == 0;
      return LeafField{(rises ? 1.0 : 1e-4) * uniform(generator), rises ? 1.0 + frame : 1.0 / (1.0 + frame)};
    });
    const FrameMarks marks = mark_frame(forest, d.mesh, f.estimate, f.von_mises, frame, d.dof_count(), rules, history);
    const FrameChange change = adapt_forest(d.mesh, marks, frame, forest, history);
    refined += change.refined;
    coarsened += change.coarsened;
  }
  CHECK(most > 1500);  // otherwise the bound was not met
  CHECK(refined > 100);
  CHECK(coarsened > 100);
}

TEST_CASE("a body at rest only coarsens, after the dwell time", "[adapt][energy floor]") {
  RefinementForest forest(box({3, 1, 1}));
  FrameAdaptHistory history;
  const FrameAdaptRules rules{.energy_floor = 1e-6, .dwell = 4, .max_depth = 3};
  // Cell 0 rises and is the worst, refined or not.
  const auto run = [&](int frame, double energy) {
    const Mesh mesh = forest.leaf_mesh();
    const Fields f = fields(mesh, energy, [&](int cell) {
      const bool worst = mesh.frames[cell].base_cell == 0;
      return LeafField{worst ? size(mesh, cell).prod() : 0.01, worst ? 1.0 + frame : 1.0};
    });
    const FrameMarks marks = mark_frame(forest, mesh, f.estimate, f.von_mises, frame, 0, rules, history);
    return adapt_forest(mesh, marks, frame, forest, history);
  };
  CHECK(run(0, 1.0).refined == 0);  // no rate yet
  CHECK(run(1, 1.0).refined == 1);
  CHECK(run(2, 1.0).refined == 8);
  CHECK(forest.leaf_count() == 2 + 64);
  for (int frame = 3; frame < 6; ++frame) {
    const FrameChange change = run(frame, 0.9e-6);
    CHECK(change.refined + change.coarsened == 0);
  }
  CHECK(run(6, 0.9e-6).coarsened == 8);
  for (int frame = 7; frame < 10; ++frame) CHECK(run(frame, 0.9e-6).coarsened == 0);
  CHECK(run(10, 0.9e-6).coarsened == 1);
  CHECK(forest.leaf_count() == 3);
  CHECK(run(11, 0.9e-6).refined == 0);
  CHECK(run(12, 1.1e-6).refined == 1);  // awake
}

TEST_CASE("no cell is refined while each tolerance that is asked for is met", "[adapt][tolerance]") {
  const RefinementForest forest(box({4, 1, 1}));
  const Mesh mesh = forest.leaf_mesh();
  // η = 0.2 and the largest η_e over the energy norm 0.1.
  const Fields f = fields(mesh, 1.0, [](int) { return LeafField{0.01, 2.0}; });
  const auto refined = [&](double global, double local) {
    return marks_after_one_frame(forest, f, {.tolerance = global, .local_tolerance = local}).refine.size();
  };
  CHECK(refined(0.0, 0.0) == 4);  // none asked
  CHECK(refined(0.19, 0.0) == 4);
  CHECK(refined(0.2, 0.0) == 0);
  CHECK(refined(0.21, 0.0) == 0);
  CHECK(refined(0.0, 0.09) == 4);
  CHECK(refined(0.0, 0.1) == 0);
  CHECK(refined(0.0, 0.11) == 0);
  CHECK(refined(0.21, 0.11) == 0);
  CHECK(refined(0.19, 0.11) == 4);
  CHECK(refined(0.21, 0.09) == 4);
}

TEST_CASE("a family goes only as a whole: none rising, none young, none refined, the error small", "[adapt]") {
  RefinementForest forest(box({2, 1, 1}));
  FrameAdaptHistory history;
  const FrameAdaptRules rules{.coarsen_below = 0.05, .dwell = 3, .max_depth = 1};
  {
    const Mesh mesh = forest.leaf_mesh();
    static_cast<void>(adapt_forest(mesh, {{{0, {}}}, {}}, 0, forest, history));
  }
  const Mesh mesh = forest.leaf_mesh();
  REQUIRE(mesh.cell_count() == 9);
  const auto coarsened = [&](int frame, double stress, double stress_of_3, double family_eta) {
    FrameAdaptHistory copy = history;
    for (const int handle : mesh.forest_cell) copy.von_mises[handle] = 1.0;
    const Fields f = fields(mesh, 1.0, [&](int cell) {
      return cell == 8 ? LeafField{1.0, 1.0}
                       : LeafField{family_eta * family_eta / 8.0, cell == 3 ? stress_of_3 : stress};
    });
    return mark_frame(forest, mesh, f.estimate, f.von_mises, frame, 0, rules, copy).coarsen.size();
  };
  CHECK(coarsened(3, 0.9, 0.9, 0.049) == 1);
  CHECK(coarsened(3, 1.0, 1.0, 0.049) == 1);  // does not rise
  CHECK(coarsened(2, 0.9, 0.9, 0.049) == 0);
  CHECK(coarsened(3, 0.9, 1.1, 0.049) == 0);
  CHECK(coarsened(3, 0.9, 0.9, 0.051) == 0);  // each is below by far, the family is not
  history.changed[mesh.forest_cell[5]] = 1;
  CHECK(coarsened(3, 0.9, 0.9, 0.049) == 0);
  CHECK(coarsened(4, 0.9, 0.9, 0.049) == 1);
}

TEST_CASE("children take their parent's stress, a parent the mean of its children's", "[adapt][history]") {
  RefinementForest forest(box({1, 1, 1}));
  FrameAdaptHistory history;
  const RefinementTemplate refinement{{4, 2, 1}};  // two levels
  history.von_mises = {7.0};
  const Mesh base = forest.leaf_mesh();
  CHECK(adapt_forest(base, {{{0, refinement}}, {}}, 5, forest, history).refined == 1);
  REQUIRE(forest.leaf_count() == 8);
  REQUIRE(history_follows(history, forest));
  const auto made = leaves(forest);
  for (const int leaf : made) {
    CHECK(history.von_mises[leaf] == 7.0);
    CHECK(history.changed[leaf] == 5);
    CHECK_FALSE(history.coarsened[leaf]);
  }
  const std::vector<int> inner = families(forest);
  REQUIRE(inner.size() == 4);
  const int first = forest.cell(inner[0]).first_child;
  history.von_mises[first] = 1.0;
  history.von_mises[first + 1] = 4.0;
  CHECK(adapt_forest(forest.leaf_mesh(), {{}, inner}, 9, forest, history).coarsened == 4);
  CHECK(history.von_mises[inner[0]] == 2.5);
  CHECK(history.von_mises[inner[1]] == 7.0);
  for (const int leaf : leaves(forest)) {
    CHECK(history.changed[leaf] == 9);
    CHECK(history.coarsened[leaf]);
  }
  CHECK(history_follows(history, forest));
}

TEST_CASE("between markings nothing is marked, and the rate is the change since the last marking", "[adapt]") {
  const RefinementForest forest(box({2, 1, 1}));
  const Mesh mesh = forest.leaf_mesh();
  FrameAdaptHistory history;
  const FrameAdaptRules rules{.every = 3};
  const auto refined = [&](int frame, double stress) {
    const Fields f = fields(mesh, 1.0, [&](int) { return LeafField{1.0, stress}; });
    return mark_frame(forest, mesh, f.estimate, f.von_mises, frame, 0, rules, history).refine.size();
  };
  CHECK(refined(0, 1.0) == 0);
  CHECK(refined(1, 9.0) == 0);
  CHECK(refined(2, 3.0) == 0);
  CHECK(refined(3, 2.0) == 2);  // below the frame before, above the last marking
  CHECK(refined(6, 2.0) == 0);
}

TEST_CASE("a thousand cycles of refinement leave history and storage as large as the forest", "[adapt][history]") {
  RefinementForest forest(box({3, 3, 3}));
  FrameAdaptHistory history;
  const auto templates = all_templates();
  std::mt19937 generator(7);
  const auto storage = [&] {
    return forest.storage_bytes() + history.von_mises.capacity() * sizeof(double) +
           history.changed.capacity() * sizeof(int) + history.coarsened.capacity();
  };
  std::size_t first_half = 0, second_half = 0;
  int refined = 0, coarsened = 0, reused = 0;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    CAPTURE(cycle);
    const Mesh mesh = forest.leaf_mesh();
    FrameMarks marks;
    std::vector<int> taken;
    for (const int family : families(forest))
      if (generator() % 100 < (forest.leaf_count() > 600 ? 80u : 25u)) marks.coarsen.push_back(family);
    std::sort(marks.coarsen.begin(), marks.coarsen.end());
    for (int cell = 0; cell < mesh.cell_count() && forest.leaf_count() <= 600; ++cell) {
      const auto& leaf = forest.cell(mesh.forest_cell[cell]);
      const RefinementTemplate refinement = templates[generator() % templates.size()];
      if (leaf.depth < 3 && generator() % 30 == 0 && forest.can_refine(mesh.forest_cell[cell], refinement) &&
          !std::binary_search(marks.coarsen.begin(), marks.coarsen.end(), leaf.parent))
        marks.refine.push_back({cell, refinement});
    }
    history.von_mises.resize(static_cast<std::size_t>(forest.handle_count()), -1.0);
    for (const int handle : mesh.forest_cell) history.von_mises[handle] = 1.0 + cycle;
    const int handles = forest.handle_count();
    const FrameChange change = adapt_forest(mesh, marks, cycle, forest, history);
    REQUIRE(change.refined == static_cast<int>(marks.refine.size()));
    REQUIRE(history_follows(history, forest));
    const auto all = leaves(forest);
    REQUIRE(std::all_of(all.begin(), all.end(), [&](int leaf) { return history.von_mises[leaf] > 0.0; }));
    reused += change.refined > 0 && forest.handle_count() <= handles;
    refined += change.refined;
    coarsened += change.coarsened;
    (cycle < 500 ? first_half : second_half) = std::max(cycle < 500 ? first_half : second_half, storage());
  }
  CHECK(refined > 5000);
  CHECK(coarsened > 5000);
  CHECK(reused > 100);
  // Capacities double, so that anything that grows with the cycles would at least double.
  CHECK(second_half < 2 * first_half);
  while (!families(forest).empty()) {
    std::vector<int> all = families(forest);
    std::sort(all.begin(), all.end());
    static_cast<void>(adapt_forest(forest.leaf_mesh(), {{}, all}, 1000, forest, history));
  }
  CHECK(forest.handle_count() == 27);
  CHECK(history_follows(history, forest));
}

TEST_CASE("the von Mises stress of cells is that of the recovery's centre stresses, and does not turn", "[adapt]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Kinematics kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  CAPTURE(shape == CellShape::hexahedron, kinematics == Kinematics::linear);
  RefinementForest forest(box({2, 2, 2}, shape));
  forest.refine(0, {});
  const Material material{.youngs_modulus = 2e3, .poisson_ratio = 0.4, .kinematics = kinematics};
  const Discretization d = discretize(forest, material, {});
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(-0.05, 0.05);
  const Eigen::Matrix3Xd u =
      Eigen::Matrix3Xd::NullaryExpr(3, d.mesh.node_count(), [&](auto, auto) { return uniform(generator); });
  const Eigen::VectorXd stress = cell_von_mises(d, u);
  const CellStresses oracle = cell_stresses(d, u);
  const double largest = stress.maxCoeff();
  CHECK(largest > 10.0);
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell)
    CHECK_THAT(stress[cell], WithinAbs(von_mises(oracle.centre.col(cell)), 1e-12 * largest));

  // Uniaxial tension: E ε, also in a body that turned where the cells' frames turn along.
  const Eigen::Vector3d strain(0.01, -0.4 * 0.01, -0.4 * 0.01);
  Eigen::Matrix3Xd stretched = d.mesh.nodes + strain.asDiagonal() * d.mesh.nodes;
  if (kinematics == Kinematics::corotational)
    stretched = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix() * stretched.eval();
  const Eigen::VectorXd uniaxial = cell_von_mises(d, stretched - d.mesh.nodes);
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) CHECK_THAT(uniaxial[cell], WithinRel(20.0, 1e-11));
}

TEST_CASE("rules out of range and errors that are no numbers are refused", "[adapt][input]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_NOTHROW(check(FrameAdaptRules{}));
  CHECK_NOTHROW(check(FrameAdaptRules{.refine_above = 0.3, .coarsen_below = 0.3}));
  for (const double theta : {0.0, -0.1, 1.1, nan})
    CHECK_THROWS_AS(check(FrameAdaptRules{.refine_above = theta}), std::invalid_argument);
  for (const double theta : {0.31, -0.1, nan})
    CHECK_THROWS_AS(check(FrameAdaptRules{.refine_above = 0.3, .coarsen_below = theta}), std::invalid_argument);
  for (const double value : {-1e-9, nan, std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_AS(check(FrameAdaptRules{.tolerance = value}), std::invalid_argument);
    CHECK_THROWS_AS(check(FrameAdaptRules{.local_tolerance = value}), std::invalid_argument);
    CHECK_THROWS_AS(check(FrameAdaptRules{.energy_floor = value}), std::invalid_argument);
  }
  CHECK_THROWS_AS(check(FrameAdaptRules{.dwell = -1}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.every = 0}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.max_depth = -1}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.max_dofs = -1}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.refinement = {{1, 1, 1}}}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.refinement = {{2, 0, 2}}}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.max_depth = 1, .refinement = {{4, 2, 2}}}), std::invalid_argument);

  const RefinementForest forest(box({2, 1, 1}));
  for (const double value : {nan, -1.0, std::numeric_limits<double>::infinity()}) {
    Fields f = fields(forest.leaf_mesh(), 1.0, [](int) { return LeafField{1.0, 2.0}; });
    f.estimate.eta[1] = value;
    CHECK_THROWS_AS(marks_after_one_frame(forest, f, {}), std::invalid_argument);
    f.estimate.eta[1] = 1.0;
    CHECK(marks_after_one_frame(forest, f, {}).refine.size() == 2);
    f.von_mises[1] = value;
    CHECK_THROWS_AS(marks_after_one_frame(forest, f, {}), std::invalid_argument);
  }
}
