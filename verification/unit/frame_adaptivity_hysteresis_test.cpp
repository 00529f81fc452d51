#include <vector>

#include "core/adapt/frame_adaptivity.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/leaf_fields.hpp"

using namespace finegauge;

namespace {

/// Two cells: the error of cell 0 and all that comes of it is `series`(frame) of that of cell 1, which rests.
struct Oscillation {
  std::vector<int> refined, coarsened, toggled;  ///< frames
};
Oscillation oscillate(const FrameAdaptRules& rules, int frames, double low, double high) {
  RefinementForest forest(box_of_cubes({2, 1, 1}));
  FrameAdaptHistory history;
  Oscillation result;
  for (int frame = 0; frame < frames; ++frame) {
    const Mesh mesh = forest.leaf_mesh();
    const double value = frame % 2 ? high : low;
    const LeafFields f = leaf_fields(mesh, 1.0, [&](int cell) {
      if (mesh.frames[cell].base_cell == 1) return LeafField{1.0, 1.0};
      return LeafField{value * value * cell_size(mesh, cell).prod(), value};
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
