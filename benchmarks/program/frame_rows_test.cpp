#include "benchmarks/program/frame_rows.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// What the contract of the result files names, in its order.
const std::vector<std::string> row_keys = {"time",          "tip_displacement",
                                           "force",         "tip_force",
                                           "shaft_force",   "across_force",
                                           "base_force",    "dofs",
                                           "cells",         "eta",
                                           "eta_local_max", "error_low",
                                           "error_high",    "equilibrium_error",
                                           "tolerance_met", "converged",
                                           "residual",      "violation",
                                           "energy",        "frame_ms",
                                           "processor_ms",  "events"};
const std::vector<std::string> summary_keys = {"frames",
                                               "frames_per_second",
                                               "frame_ms",
                                               "deadline_ms",
                                               "missed_frames",
                                               "longest_miss_streak",
                                               "stages_ms",
                                               "dofs",
                                               "cells",
                                               "hanging_nodes",
                                               "eta",
                                               "tolerance",
                                               "refined",
                                               "coarsened",
                                               "popping",
                                               "solver_iterations",
                                               "uzawa_iterations",
                                               "constraint_violation_max",
                                               "unconverged_frames",
                                               "heap_allocations_per_quiet_frame",
                                               "peak_memory_mb",
                                               "state_sha256"};

Scene moving_scene(bool needle) {
  Scene scene;
  scene.name = "made_up";
  BoxMeshOptions box;
  box.cells = {2, 2, 2};
  scene.geometry = box;
  scene.dynamics.emplace();
  if (needle) scene.needle.emplace();
  return scene;
}

/// Four frames of made-up numbers, all different.
MotionRun made_up_run() {
  MotionRun run;
  run.planned_frames = 4;
  for (int i = 1; i <= 4; ++i) {
    MotionFrame frame;
    FrameReport& f = frame.report.frame;
    f.frame = i, f.time = 0.5 * i;
    f.dofs = 100 * (5 - i), f.cells = 10 + (i == 2 ? 7 : 0), f.hanging_nodes = i;
    f.eta = 0.1 * i, f.eta_local_max = 0.01 * i;
    f.violation = 1e-9 * i, f.residual = 1e-10, f.solver_iterations = 2 * i, f.uzawa_iterations = i * i;
    f.energy = {.kinetic = 1.0, .elastic = 2.0 * i, .work = 10.0, .dissipated = 1.0, .closure = -0.5};
    frame.report.force = i == 3 ? -7.0 : i, frame.report.tip_force = 0.5 * i;
    frame.report.tip_displacement = 1e-3 * i;
    frame.frame_ms = 10.0 * i;
    frame.heap_allocations = 100 * i;
    run.frames.push_back(frame);
  }
  run.frames[1].report.events.push_back({ContactEventKind::puncture, 1.0, 0.002, 10.5});
  run.frames[3].report.frame.refined = 3;
  run.final_state = {1.0, 2.0};
  return run;
}

}  // namespace

TEST_CASE("a row has every key that result files promise, in any scene", "[rows]") {
  const bool needle = GENERATE(true, false);
  const Json row = to_json(made_up_run().frames[1], moving_scene(needle));
  std::size_t last = 0;
  std::vector<std::string> found;
  for (const auto& [key, value] : row.items()) found.push_back(key);
  for (const std::string& key : row_keys) {
    CAPTURE(key, needle);
    const auto at = std::ranges::find(found, key);
    REQUIRE(at != found.end());
    CHECK(static_cast<std::size_t>(at - found.begin()) >= last);  // in the order of the contract
    last = static_cast<std::size_t>(at - found.begin());
    if (row.at(key).is_null()) CHECK_FALSE(row.at(key + "_reason").get<std::string>().empty());
  }
  CHECK(row.at("force").is_null() != needle);
  // A needle's forces have no range; the error of a body that moves by itself lies between its bounds.
  CHECK(row.at("error_low").is_null() == needle);
  if (!needle) {
    CHECK(row.at("error_low").get<double>() < row.at("eta").get<double>());
    CHECK(row.at("error_high").get<double>() > row.at("eta").get<double>());
  }
  for (const char* part : {"kinetic", "elastic", "work", "release", "dissipated", "closure"})
    CHECK(row.at("energy").at(part).is_number());
  REQUIRE(row.at("events").size() == 1);
  CHECK(row.at("events")[0] == Json{{"kind", "puncture"}, {"time", 1.0}, {"depth", 0.002}, {"force", 10.5}});
}

TEST_CASE("the table of rows has the same columns with and without events, and events as text", "[rows]") {
  const MotionRun run = made_up_run();
  const Scene scene = moving_scene(true);
  const auto header_of = [](const Json& rows) { return to_csv(rows).substr(0, to_csv(rows).find('\n')); };
  const Json with = Json::array({to_json(run.frames[1], scene)}), none = Json::array({to_json(run.frames[0], scene)});
  CHECK(header_of(with) == header_of(none));
  CHECK(to_csv(with).find("\"\"kind\"\":\"\"puncture\"\"") != std::string::npos);
  CHECK(to_csv(none).find("[]") != std::string::npos);
}

TEST_CASE("a summary has every key that result files promise, and the right frame's numbers in them", "[rows]") {
  const MotionRun run = made_up_run();
  Scene scene = moving_scene(true);
  scene.dynamics->deadline_ms = 15.0;
  const Json s = summarize(scene, run);
  for (const std::string& key : summary_keys) {
    CAPTURE(key);
    CHECK(s.contains(key));
  }
  CHECK(s.at("frames") == 4);
  CHECK(s.at("frames_per_second").get<double>() == Approx(40.0));  // 4 frames in 100 ms
  CHECK(s.at("frame_ms") == Json{{"p50", 20.0}, {"p95", 40.0}, {"p99", 40.0}, {"max", 40.0}});
  CHECK(s.at("missed_frames") == 3);
  CHECK(s.at("longest_miss_streak") == 3);
  CHECK(s.at("dofs") == Json{{"start", 400}, {"max", 400}, {"end", 100}});
  CHECK(s.at("cells") == Json{{"start", 10}, {"max", 17}, {"end", 10}});
  CHECK(s.at("hanging_nodes") == Json{{"max", 4}});
  CHECK(s.at("eta").at("max").get<double>() == 0.4);
  CHECK(s.at("solver_iterations") == Json{{"mean", 5.0}, {"max", 8}});
  CHECK(s.at("uzawa_iterations") == Json{{"mean", 7.5}, {"max", 16}});
  CHECK(s.at("constraint_violation_max") == 4e-9);
  CHECK(s.at("largest_force") == -7.0);
  CHECK(s.at("events").at("puncture") == 1);
  CHECK(s.at("heap_allocations_per_quiet_frame") == 100.0);  // frames 1 and 3: 2 has an event, 4 refines
  CHECK(s.at("energy").at("relative_closure").get<double>() == -0.05);
}

TEST_CASE("what a run has not is null with a reason", "[rows]") {
  MotionRun run = made_up_run();
  for (MotionFrame& frame : run.frames) {
    frame.heap_allocations.reset();
    frame.report.frame.eta.reset(), frame.report.frame.eta_local_max.reset();
  }
  Scene scene = moving_scene(false);
  scene.dynamics->estimate_error = false;
  const Json s = summarize(scene, run);
  for (const char* key : {"deadline_ms", "missed_frames", "longest_miss_streak", "heap_allocations_per_quiet_frame"}) {
    CAPTURE(key);
    CHECK(s.at(key).is_null());
    CHECK_FALSE(s.at(std::string(key) + "_reason").get<std::string>().empty());
  }
  CHECK(s.at("eta").at("start").is_null());
  CHECK(s.at("eta").at("max_reason") == "estimate_error = false");
  CHECK(to_json(run.frames[0], scene).at("eta_reason") == "estimate_error = false");
}

TEST_CASE("the summary tells on which frames a tolerance was met, by how much it was missed and why", "[rows]") {
  Scene scene = moving_scene(true);
  scene.dynamics->adapt = FrameAdaptRules{.tolerance = 0.2};
  MotionRun run = made_up_run();  // four frames
  const auto set = [&](int i, bool at_rest, bool met, double ratio, AdaptLimit limit) {
    FrameReport& f = run.frames[static_cast<std::size_t>(i)].report.frame;
    f.at_rest = at_rest, f.tolerance_met = met, f.tolerance_ratio = ratio, f.limit = limit;
  };
  set(0, false, true, 0.9, AdaptLimit::none);
  set(1, false, false, 1.5, AdaptLimit::depth);
  set(2, false, false, 1.2, AdaptLimit::none);
  set(3, true, false, 9.0, AdaptLimit::none);  // at rest none is asked
  const Json t = summarize(scene, run).at("tolerance");
  CHECK(t.at("asked_frames") == 3);
  CHECK(t.at("met_frames") == 1);
  CHECK(t.at("share").get<double>() == Approx(1.0 / 3.0));
  CHECK(t.at("worst") == 1.5);
  CHECK(t.at("frames_limited_by_depth") == 1);
  CHECK(t.at("local_met_frames_reason") == "the scene asks for no tolerance of the worst cell's error");
  CHECK(t.at("frames_limited_by_dofs") == 0);
  const Json row = to_json(run.frames[1], scene);
  CHECK(row.at("tolerance_ratio") == 1.5);
  CHECK(row.at("limit") == "depth");
  CHECK(to_json(run.frames[3], scene).at("at_rest") == true);

  scene.dynamics->adapt->tolerance = 0.0;
  const Json none = summarize(scene, run).at("tolerance");
  CHECK(none.at("share").is_null());
  CHECK(none.at("share_reason") == "the scene asks for no tolerance");
  CHECK(none.at("global_met_frames_reason") == "the scene asks for no tolerance");
  CHECK(to_json(run.frames[1], scene).at("tolerance_ratio").is_null());
}

TEST_CASE("of two tolerances the summary tells on which frames each was met", "[rows]") {
  Scene scene = moving_scene(true);
  scene.dynamics->adapt = FrameAdaptRules{.tolerance = 0.2, .local_tolerance = 0.05};
  MotionRun run = made_up_run();  // four frames
  const auto set = [&](int i, double eta, double local, bool at_rest) {
    FrameReport& f = run.frames[static_cast<std::size_t>(i)].report.frame;
    f.eta = eta, f.eta_local_max = local, f.at_rest = at_rest;
  };
  set(0, 0.19, 0.06, false);
  set(1, 0.2, 0.05, false);
  set(2, 0.21, 0.04, false);
  set(3, 0.1, 0.01, true);  // at rest none is asked
  Json t = summarize(scene, run).at("tolerance");
  CHECK(t.at("global_met_frames") == 2);
  CHECK(t.at("local_met_frames") == 2);
  set(1, 0.2, 0.07, false);
  t = summarize(scene, run).at("tolerance");
  CHECK(t.at("global_met_frames") == 2);
  CHECK(t.at("local_met_frames") == 1);
}

TEST_CASE("the summary counts changes of the mesh, those taken back, and what they did to the force", "[rows]") {
  Scene scene = moving_scene(true);
  scene.dynamics->time_step = 0.5;
  scene.dynamics->adapt = FrameAdaptRules{.release = 4};
  scene.dynamics->check_popping = true;
  MotionRun run = made_up_run();
  run.frames[1].report.frame.coarsened = 2, run.frames[1].report.frame.toggles = 3;
  run.mesh_changes.push_back({.frame = 2, .asked = -0.7, .excess = 0.07, .largest_step = 0.35, .judged = true});
  run.mesh_changes.push_back({.frame = 4, .asked = 5.0, .excess = 5.0, .largest_step = 5.0, .judged = false});
  const Json p = summarize(scene, run).at("popping");
  CHECK(p.at("release_frames") == 4);
  CHECK(p.at("mesh_changes") == 2);  // frame 4 refines
  CHECK(p.at("toggles") == 3);
  CHECK(p.at("toggles_per_cell_and_second").get<double>() == Approx(3.0 / (0.5 * (10 + 17 + 10 + 10))));
  CHECK(p.at("judged_changes") == 1);
  CHECK(p.at("largest_excess").get<double>() == Approx(0.01));  // of 7 N
  CHECK(p.at("largest_step").get<double>() == Approx(0.05));
  CHECK(p.at("largest_asked").get<double>() == Approx(0.1));
  const auto excess = [&] {
    for (const Json& check : motion_checks(run, false))
      if (check.at("name") == "popping_excess") return check.at("ok").get<bool>();
    FAIL("no such check");
    return false;
  };
  CHECK(excess());
  run.mesh_changes[0].excess = 0.15;  // above two percent of 7 N
  CHECK_FALSE(excess());
  scene.dynamics->check_popping = false;
  CHECK(summarize(scene, run).at("popping").at("largest_excess").is_null());
  scene.dynamics->adapt.reset();
  CHECK(summarize(scene, run).at("popping").at("mesh_changes").is_null());
}

TEST_CASE("frames that did not converge fail a check and are told by the first of them", "[rows]") {
  MotionRun run = made_up_run();
  CHECK(convergence_failure(run).empty());
  CHECK(all_checks_hold(motion_checks(run, false)));
  run.frames[1].report.frame.converged = run.frames[2].report.frame.converged = false;
  run.frames[1].report.frame.violation = 0.25;
  CHECK(convergence_failure(run).find("2 of 4 frames did not converge, the first is frame 2 (t = 1): residual 1e-10, "
                                      "violation 0.25") == 0);
  CHECK_FALSE(all_checks_hold(motion_checks(run, false)));
}

TEST_CASE("a run with frames missing fails its check unless the user ended it", "[rows]") {
  MotionRun run = made_up_run();
  run.planned_frames = 5;
  CHECK_FALSE(all_checks_hold(motion_checks(run, false)));
  CHECK(all_checks_hold(motion_checks(run, true)));
}

TEST_CASE("a violation that is no number is not hidden by the others", "[rows]") {
  MotionRun run = made_up_run();
  run.frames[2].report.frame.violation = std::numeric_limits<double>::quiet_NaN();
  const double violation = summarize(moving_scene(true), run).at("constraint_violation_max").get<double>();
  CHECK(violation != violation);
}

TEST_CASE("a force above the buckling load is noted where nothing guides the needle", "[rows]") {
  MotionRun run = made_up_run();
  run.buckling_load = 3.0;  // the largest force is 4
  Scene scene = moving_scene(true);
  CHECK(run_notes(scene, run).empty());
  scene.needle->drive.guided = false;
  REQUIRE(run_notes(scene, run).size() == 1);
  CHECK(run_notes(scene, run)[0].find("buckling load, 3") != std::string::npos);
  run.buckling_load = 5.0;
  CHECK(run_notes(scene, run).empty());
}

TEST_CASE("contact forces that do not settle are noted with what helps", "[rows]") {
  MotionRun run = made_up_run();
  Scene scene = moving_scene(true);
  scene.needle->interaction.iterations = 9;      // what the third frame took; the fourth took more
  CHECK(run_notes(scene, run).empty());          // but all converged
  run.frames[1].report.frame.converged = false;  // for another reason
  CHECK(run_notes(scene, run).empty());
  run.frames[2].report.frame.converged = false;
  REQUIRE(run_notes(scene, run).size() == 1);
  CHECK(run_notes(scene, run)[0].find("in 1 frames") != std::string::npos);
  CHECK(run_notes(moving_scene(false), run).empty());
}

TEST_CASE("an energy ledger that does not close is noted with the frame that was least in equilibrium", "[rows]") {
  MotionRun run = made_up_run();
  const Scene scene = moving_scene(true);
  run.frames[2].report.frame.equilibrium_error = 0.7;
  run.frames[3].report.frame.equilibrium_error = 0.9;
  run.frames[3].report.frame.at_rest = true;         // of almost nothing
  run.frames[3].report.frame.energy.closure = -0.5;  // of 10: what is allowed
  CHECK(run_notes(scene, run).empty());
  for (const double closure : {-0.6, 0.6}) {
    run.frames[3].report.frame.energy.closure = closure;
    REQUIRE(run_notes(scene, run).size() == 1);
    CHECK(run_notes(scene, run)[0].find("6 % of the largest") != std::string::npos);
    CHECK(run_notes(scene, run)[0].find("up to 0.7, at t = 1.5") != std::string::npos);
  }
}

TEST_CASE("quantities of interest are summed up as the largest and the last", "[rows]") {
  MotionRun run = made_up_run();
  Scene scene = moving_scene(true);
  scene.quantities = {{"tip", QuantityKind::tip_force, {}},
                      {"curve", QuantityKind::force_curve, {}},
                      {"end", QuantityKind::displacement, {}},
                      {"energy", QuantityKind::energy, {}}};
  for (std::size_t i = 0; i < 4; ++i) {
    run.frames[i].quantities["end"] = {0.0, i == 1 ? -3.0 : 1.0, 0.0};
    run.frames[i].quantities["energy"] = i == 2 ? 9.0 : 1.0;
  }
  const Json q = summarize(scene, run).at("quantities");
  CHECK(q.at("tip") == Json{{"largest", 2.0}, {"final", 2.0}});
  CHECK(q.at("curve") == Json{{"file", "made_up.csv"}, {"x", "tip_displacement"}, {"y", "force"}});
  CHECK(q.at("end").at("largest") == Json::array({0.0, -3.0, 0.0}));
  CHECK(q.at("end").at("final") == Json::array({0.0, 1.0, 0.0}));
  CHECK(q.at("energy") == Json{{"largest", 9.0}, {"final", 1.0}});
}
