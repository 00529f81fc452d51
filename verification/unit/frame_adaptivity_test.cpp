#include "core/adapt/frame_adaptivity.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "core/space/discretization.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/leaf_fields.hpp"
#include "verification/support/refinement_history.hpp"

using namespace finegauge;

TEST_CASE("a body at rest only coarsens, after the dwell time", "[adapt][energy floor]") {
  RefinementForest forest(box_of_cubes({3, 1, 1}));
  FrameAdaptHistory history;
  const FrameAdaptRules rules{.energy_floor = 1e-6, .dwell = 4, .max_depth = 3};
  // Cell 0 rises and is the worst, refined or not.
  const auto run = [&](int frame, double energy) {
    const Mesh mesh = forest.leaf_mesh();
    const LeafFields f = leaf_fields(mesh, energy, [&](int cell) {
      const bool worst = mesh.frames[cell].base_cell == 0;
      return LeafField{worst ? cell_size(mesh, cell).prod() : 0.01, worst ? 1.0 + frame : 1.0};
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

TEST_CASE("refinement sets in at a share of each tolerance that is asked for", "[adapt][tolerance]") {
  const RefinementForest forest(box_of_cubes({4, 1, 1}));
  const Mesh mesh = forest.leaf_mesh();
  // η = 0.2 and the largest η_e over the energy norm 0.1.
  const LeafFields f = leaf_fields(mesh, 1.0, [](int) { return LeafField{0.01, 2.0}; });
  const auto refined = [&](double global, double local) {
    return marks_after_one_frame(forest, f, {.tolerance = global, .local_tolerance = local, .refine_at = 0.8})
        .refine.size();
  };
  CHECK(refined(0.0, 0.0) == 4);  // none asked: the paper's rule, all rise
  CHECK(refined(0.19, 0.0) == 4);
  CHECK(refined(0.2, 0.0) == 4);  // met, but hardly
  CHECK(refined(0.249, 0.0) == 4);
  CHECK(refined(0.25, 0.0) == 0);
  CHECK(refined(0.251, 0.0) == 0);
  CHECK(refined(0.0, 0.124) == 4);
  CHECK(refined(0.0, 0.125) == 0);
  CHECK(refined(0.0, 0.126) == 0);
  CHECK(refined(0.26, 0.13) == 0);
  CHECK(refined(0.24, 0.13) == 4);
  CHECK(refined(0.26, 0.12) == 4);
}

TEST_CASE("how far a tolerance is missed, the worse of two", "[adapt][tolerance]") {
  const RefinementForest forest(box_of_cubes({4, 1, 1}));
  const LeafFields f = leaf_fields(forest.leaf_mesh(), 1.0, [](int) { return LeafField{0.01, 2.0}; });
  const auto ratio = [&](double global, double local) {
    return tolerance_ratio(f.estimate, {.tolerance = global, .local_tolerance = local});
  };
  CHECK(ratio(0.0, 0.0) == 0.0);
  CHECK_THAT(ratio(0.1, 0.0), WithinRel(2.0, 1e-14));
  CHECK_THAT(ratio(0.0, 0.04), WithinRel(2.5, 1e-14));
  CHECK_THAT(ratio(0.1, 0.04), WithinRel(2.5, 1e-14));
  CHECK_THAT(ratio(0.1, 0.08), WithinRel(2.0, 1e-14));
  const LeafFields none = leaf_fields(forest.leaf_mesh(), 1.0, [](int) { return LeafField{0.0, 2.0}; });
  CHECK(tolerance_ratio(none.estimate, {.tolerance = 0.1, .local_tolerance = 0.1}) == 0.0);
  const LeafFields no_energy = leaf_fields(forest.leaf_mesh(), 0.0, [](int) { return LeafField{0.01, 2.0}; });
  CHECK(std::isinf(tolerance_ratio(no_energy.estimate, {.tolerance = 0.1})));
}

TEST_CASE("a family goes only as a whole: none rising, none young, none refined, the error small", "[adapt]") {
  RefinementForest forest(box_of_cubes({2, 1, 1}));
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
    const LeafFields f = leaf_fields(mesh, 1.0, [&](int cell) {
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
  RefinementForest forest(box_of_cubes({1, 1, 1}));
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
  const RefinementForest forest(box_of_cubes({2, 1, 1}));
  const Mesh mesh = forest.leaf_mesh();
  FrameAdaptHistory history;
  const FrameAdaptRules rules{.every = 3};
  const auto refined = [&](int frame, double stress) {
    const LeafFields f = leaf_fields(mesh, 1.0, [&](int) { return LeafField{1.0, stress}; });
    return mark_frame(forest, mesh, f.estimate, f.von_mises, frame, 0, rules, history).refine.size();
  };
  CHECK(refined(0, 1.0) == 0);
  CHECK(refined(1, 9.0) == 0);
  CHECK(refined(2, 3.0) == 0);
  CHECK(refined(3, 2.0) == 2);  // below the frame before, above the last marking
  CHECK(refined(6, 2.0) == 0);
}

TEST_CASE("a thousand cycles of refinement leave history and storage as large as the forest", "[adapt][history]") {
  RefinementForest forest(box_of_cubes({3, 3, 3}));
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
  RefinementForest forest(box_of_cubes({2, 2, 2}, shape));
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
  for (const double share : {0.0, -0.1, 1.1, nan})
    CHECK_THROWS_AS(check(FrameAdaptRules{.refine_at = share}), std::invalid_argument);
  for (const double share : {0.9, 0.95, -0.1, nan})
    CHECK_THROWS_AS(check(FrameAdaptRules{.coarsen_at = share}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.release = -1}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.dwell = -1}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.every = 0}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.max_depth = -1}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.max_dofs = -1}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.refinement = {{1, 1, 1}}}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.refinement = {{2, 0, 2}}}), std::invalid_argument);
  CHECK_THROWS_AS(check(FrameAdaptRules{.max_depth = 1, .refinement = {{4, 2, 2}}}), std::invalid_argument);

  const RefinementForest forest(box_of_cubes({2, 1, 1}));
  for (const double value : {nan, -1.0, std::numeric_limits<double>::infinity()}) {
    LeafFields f = leaf_fields(forest.leaf_mesh(), 1.0, [](int) { return LeafField{1.0, 2.0}; });
    f.estimate.eta[1] = value;
    CHECK_THROWS_AS(marks_after_one_frame(forest, f, {}), std::invalid_argument);
    f.estimate.eta[1] = 1.0;
    CHECK(marks_after_one_frame(forest, f, {}).refine.size() == 2);
    f.von_mises[1] = value;
    CHECK_THROWS_AS(marks_after_one_frame(forest, f, {}), std::invalid_argument);
  }
}
