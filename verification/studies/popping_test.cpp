#include "verification/studies/popping.hpp"

#include <algorithm>
#include <cmath>

#include "verification/support/catch.hpp"
#include "verification/support/insertion_setup.hpp"

using namespace finegauge;

namespace {

struct PoppingRun {
  std::vector<InsertionReport> frames;
  std::vector<CheckedChange> changes;
  double largest_force = 0.0;  // [N]
};

const std::vector<Stroke> slow{{{0.0125, 0.0, 0.0}, 1.25}};

/// A needle pressed on a block until it gives way, with a mesh that follows.
PoppingRun press(FrameAdaptRules rules, int frames) {
  InsertionSetup setup;
  setup.estimate_error = true;
  setup.adapt = rules;
  setup.strokes = slow;
  InsertionCase made = insertion_case(setup);
  Insertion insertion = start_insertion(std::move(made.forest), made.problem);
  PoppingRun run;
  for (int k = 0; k < frames; ++k) {
    run.frames.push_back(advance_checked(made.problem, insertion, run.changes));
    run.largest_force = std::max(run.largest_force, std::abs(run.frames.back().force));
  }
  return run;
}

}  // namespace

TEST_CASE("a mesh refined under load: the force goes where equilibrium asks, in equal parts", "[popping]") {
  const int release = GENERATE(0, 2, 10);
  CAPTURE(release);
  // Marked once, when 4.4 N press on the tip.
  const PoppingRun run = press({.tolerance = 0.3, .every = 30, .release = release}, 30);
  REQUIRE(run.changes.size() == 1);
  const CheckedChange& change = run.changes.front();
  REQUIRE(change.judged);
  REQUIRE(change.refined > 10);
  REQUIRE(change.frames == std::max(release, 1) + frames_after_release);
  CHECK(change.force > 4.0);
  // A finer mesh is softer; the tip's cells are half as large, and a point's displacement grows by some percent.
  CHECK(change.asked < -0.01 * change.force);
  CHECK(change.asked > -0.10 * change.force);
  // Damping and inertia have died down to what their rate, a few times in a frame, leaves after the last ones.
  CHECK_THAT(change.reached, WithinRel(change.asked, 2e-3));
  CHECK(change.excess <= 1e-4 * change.force);
  const double part = std::abs(change.asked) / std::max(release, 1);
  if (release > 1) {
    CHECK(change.largest_step <= 1.05 * part);
    CHECK(change.largest_step >= 0.95 * part);
  } else {
    CHECK(change.largest_step >= 0.75 * part);  // the rest follows as the damping allows
    CHECK(change.largest_step <= 1.05 * part);
  }
}

TEST_CASE("no change of the mesh moves the force by two percent more than its equilibrium asks", "[popping]") {
  const PoppingRun run = press({.tolerance = 0.45, .release = 10}, 126);
  const PoppingSummary summary = summarize(run.changes);
  const auto coarsened =
      std::ranges::count_if(run.changes, [](const CheckedChange& c) { return c.judged && c.coarsened > 0; });
  REQUIRE(summary.judged >= 8);
  REQUIRE(coarsened >= 3);
  REQUIRE(summary.judged < summary.changes);  // one came with a cut
  CHECK(summary.largest_asked > 5e-4 * run.largest_force);
  CHECK(summary.largest_excess <= 1e-4 * run.largest_force);  // two percent are allowed
  CHECK(summary.largest_step <= 0.12 * summary.largest_asked);
}

TEST_CASE("checking changes nothing of the run", "[popping][determinism]") {
  const FrameAdaptRules rules{.tolerance = 0.45, .release = 10};
  InsertionSetup setup;
  setup.estimate_error = true;
  setup.adapt = rules;
  setup.strokes = slow;
  const InsertionRun plain = run_insertion(setup, 26);
  const PoppingRun checked = press(rules, 26);
  REQUIRE_FALSE(checked.changes.empty());
  for (std::size_t k = 0; k < plain.frames.size(); ++k) {
    CHECK(plain.frames[k].force == checked.frames[k].force);
    CHECK(plain.frames[k].frame.dofs == checked.frames[k].frame.dofs);
  }
}
