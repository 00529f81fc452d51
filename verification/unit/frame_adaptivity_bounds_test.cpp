#include <algorithm>
#include <random>

#include "core/adapt/frame_adaptivity.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/leaf_fields.hpp"
#include "verification/support/refinement_history.hpp"

using namespace finegauge;

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
  RefinementForest forest(box_of_cubes({3, 2, 2}, shape));
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
    const LeafFields f = leaf_fields(d.mesh, 1.0, [&](int) {
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
  const RefinementForest forest(box_of_cubes({1, 1, 1}));
  const LeafFields f = leaf_fields(forest.leaf_mesh(), 1.0, [](int) { return LeafField{1.0, 2.0}; });
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

TEST_CASE("a lone tetrahedron is refined exactly if the middles of its six edges fit", "[adapt][bounds]") {
  BaseMesh base;
  base.shape = CellShape::tetrahedron;
  base.nodes = Eigen::Matrix3Xd::Zero(3, 4);
  base.nodes.rightCols<3>().setIdentity();
  base.cells.push_back({0, 1, 2, 3, -1, -1, -1, -1});
  const RefinementForest forest(base);
  const LeafFields f = leaf_fields(forest.leaf_mesh(), 1.0, [](int) { return LeafField{1.0, 2.0}; });
  for (const int spare : {-3, -1, 0, 3}) {
    CAPTURE(spare);
    const FrameAdaptRules rules{.max_depth = 2, .max_dofs = 3 * (4 + 6) + spare};
    CHECK(marks_after_one_frame(forest, f, rules, 12).refine.size() == (spare < 0 ? 0u : 1u));
  }
}

TEST_CASE("the bound on dofs holds among templates of all kinds, while cells coarsen too", "[adapt][bounds]") {
  RefinementForest forest(box_of_cubes({2, 2, 2}));
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
    const LeafFields f = leaf_fields(d.mesh, 1.0, [&](int cell) {
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
