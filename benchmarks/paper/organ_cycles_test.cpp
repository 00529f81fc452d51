#include "benchmarks/paper/organ_cycles.hpp"

#include <array>
#include <cmath>

#include "benchmarks/paper/needle_cases.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// The scene of the long run on fewer cells, with a shorter way.
Scene small_scene(bool by_tolerance) {
  std::vector<std::string> overrides = {"organ.cell_size=0.05", "dynamics.time_step=2e-2",
                                        "stroke[0].displacement=[0,0,0.03]", "stroke[0].speed=0.05",
                                        "contact.puncture_strength=4"};
  if (by_tolerance) {
    overrides.emplace_back("adapt.tolerance=0.6");
    overrides.emplace_back("adapt.local_tolerance=0.2");
  }
  return read_scene(scene_file("liver_phantom"), overrides);
}

const Json& named(const Json& checks, const std::string& name) {
  for (const Json& one : checks)
    if (one.at("name") == name) return one;
  throw std::out_of_range("no check " + name);
}

/// Cycles that differ by what a machine and an allocator do by themselves.
OrganRun made_up_run() {
  OrganRun run{723, {}};
  for (int k = 0; k < 100; ++k) {
    OrganCycle cycle;
    cycle.frame_ms = 3.0 + 0.5 * (k % 7), cycle.new_ms = cycle.frame_ms;
    cycle.ratio = 1.0 + 0.01 * std::sin(1.7 * k);
    cycle.allocations = 330.0 + k % 2;
    cycle.resident_mb = (k < 10 ? 20.0 + k : 30.0 + 0.1 * (k % 3)) + (k < 40 ? 0.0 : 4.0);
    cycle.heap_bytes = 4'000'000 + 1000 * (k % 5);
    cycle.storage_bytes = 50'000;
    cycle.most_dofs = 1287, cycle.dofs_at_rest = 723;
    cycle.left_u = 1e-10, cycle.left_v = 1e-11;
    cycle.punctures = cycle.exits = 1;
    run.cycles.push_back(cycle);
  }
  return run;
}

}  // namespace

TEST_CASE("an organ comes back bit for bit from each insertion", "[cycles]") {
  const bool by_tolerance = GENERATE(false, true);
  CAPTURE(by_tolerance);
  const OrganRun run = run_organ_cycles(
      small_scene(by_tolerance), 3, [](double) {}, [] { return false; });
  REQUIRE(run.cycles.size() == 3);
  for (const Json& one : checks_of_return("small", run)) {
    INFO(one.dump());
    CHECK(one.at("ok") == true);
  }
  for (const OrganCycle& cycle : run.cycles) {
    CAPTURE(cycle.changed, cycle.most_dofs);
    CHECK(cycle.ratio > 0.0);
    CHECK(cycle.most_dofs == run.cycles[0].most_dofs);
  }
}

TEST_CASE("the long run ends where it is told to", "[cycles]") {
  int asked = 0;
  CHECK(run_organ_cycles(
            small_scene(false), 3, [](double) {}, [&] { return ++asked > 5; })
            .cycles.empty());
}

TEST_CASE("a trend has the growth of its line and the error of its scatter", "[cycles]") {
  const std::array straight = {1.0, 1.5, 2.0, 2.5};
  CHECK_THAT(trend(straight).growth, WithinAbs(1.5, 1e-15));
  CHECK_THAT(trend(straight).uncertainty, WithinAbs(0.0, 1e-15));
  // By hand: slope 0.3, residuals 0.3, -0.9, 0.9, -0.3, so s² = 1.8/2 and the slope's error sqrt(0.9/5).
  const std::array bent = {1.0, 0.1, 2.2, 1.3};
  CHECK_THAT(trend(bent).growth, WithinAbs(0.9, 1e-14));
  CHECK_THAT(trend(bent).uncertainty, WithinAbs(3.0 * std::sqrt(0.9 / 5.0), 1e-14));
  CHECK_THROWS_AS(trend(std::array{1.0, 2.0}), std::invalid_argument);
}

TEST_CASE("what wears out, piles up or slows down does not pass", "[cycles]") {
  const OrganRun sound = made_up_run();
  CHECK(all_checks_hold(checks_of_return("x", sound)));
  CHECK(all_checks_hold(checks_of_growth("x", sound.cycles)));
  const auto returns = [&](const std::string& name, const auto& spoil) {
    OrganRun run = sound;
    spoil(run.cycles);
    return named(checks_of_return("x", run), "cycles.x." + name).at("ok").get<bool>();
  };
  using Cycles = std::vector<OrganCycle>;
  CHECK_FALSE(returns("with_one_puncture_and_exit", [](Cycles& c) { c[40].exits = 2; }));
  CHECK_FALSE(returns("with_refinement", [](Cycles& c) { c[99].most_dofs = 723; }));
  CHECK_FALSE(returns("with_unconverged_frames", [](Cycles& c) { c[7].unconverged = 1; }));
  CHECK_FALSE(returns("with_other_dofs_at_rest", [](Cycles& c) { c[7].dofs_at_rest = 747; }));
  CHECK_FALSE(returns("not_bit_for_bit_as_at_the_start", [](Cycles& c) { c[99].changed.push_back('T'); }));
  CHECK_FALSE(returns("displacement_left", [](Cycles& c) { c[7].left_u = 1e-7; }));
  CHECK_FALSE(returns("displacement_left", [](Cycles& c) { c[7].left_u = std::nan(""); }));
  CHECK_FALSE(returns("velocity_left", [](Cycles& c) { c[7].left_v = 1e-7; }));
  CHECK_FALSE(returns("storage_growth_bytes", [](Cycles& c) { c[99].storage_bytes += 8; }));

  const auto grows = [&](const std::string& name, const auto& spoil) {
    Cycles cycles = sound.cycles;
    for (int k = 0; k < 100; ++k) spoil(k, cycles[static_cast<std::size_t>(k)]);
    return !named(checks_of_growth("x", cycles), "cycles.x." + name).at("ok").get<bool>();
  };
  CHECK(grows("frame_time_growth", [](int k, OrganCycle& c) { c.ratio *= 1.0 + 5e-4 * k; }));
  CHECK(grows("frame_time_growth", [](int k, OrganCycle& c) { c.ratio *= 1.0 - 5e-4 * k; }));
  CHECK(grows("frame_time_growth_uncertainty", [](int k, OrganCycle& c) { c.ratio += 0.1 * std::sin(2.3 * k); }));
  CHECK(grows("resident_growth_mb", [](int k, OrganCycle& c) { c.resident_mb += 0.04 * k; }));
  CHECK(
      grows("resident_growth_uncertainty_mb", [](int k, OrganCycle& c) { c.resident_mb += 5.0 * std::sin(2.3 * k); }));
  CHECK(grows("heap_growth_kb", [](int k, OrganCycle& c) { *c.heap_bytes += 1000 * k; }));
  CHECK(grows("allocations_last_tenth_over_first", [](int k, OrganCycle& c) { *c.allocations += 0.2 * k; }));
}
