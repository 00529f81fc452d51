#include "verification/studies/friction_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "verification/support/insertion_setup.hpp"

namespace finegauge {

namespace {

std::string yes_or_no(bool value) { return value ? "yes" : "no"; }

void show_incline(Evidence& evidence) {
  EvidenceTable table{"A block on an incline, mu 0.5 down the axis and 0.1 up it",
                      {"mu", "tan(slope) / mu", "moves", "sticks", "acceleration [m/s^2]", "g (sin - mu cos)"},
                      {}};
  const InclineCase standard;
  double worst = 0.0, held = 0.0;
  int wrong = 0;
  for (const bool down : {true, false}) {
    const double mu = down ? standard.friction_in : standard.friction_out;
    for (const double ratio : {0.0, 0.5, 0.9999, 1.0001, 2.0, 20.0}) {
      InclineCase tried = standard;
      const double slope = std::atan(ratio * mu);
      tried.slope = down ? slope : -slope;
      const InclineRow row = slide_on_incline(tried);
      const double sign = down ? 1.0 : -1.0;
      const double exact = ratio > 1.0 ? gravity * (std::sin(slope) - mu * std::cos(slope)) : 0.0;
      table.rows.push_back({mu, ratio, down ? "in" : "out", yes_or_no(row.sticks), sign * row.acceleration, exact});
      wrong += row.sticks != (ratio < 1.0);
      double& error = ratio < 1.0 ? held : worst;
      error = std::max(error, std::abs(sign * row.acceleration - exact) / gravity);
    }
  }
  // Thrown up the slope: friction and weight both slow it down; then it comes to rest, or back.
  EvidenceTable thrown_table{"The same thrown up the slope at 1 m/s",
                             {"tan(slope)", "steps", "sticks", "speed at the end [m/s]", "closed form"},
                             {}};
  double thrown_error = 0.0;
  const double slope = std::atan(0.3);
  const double slows = gravity * (std::sin(slope) + standard.friction_out * std::cos(slope));
  for (const int steps : {100, 400}) {
    // Up is withdrawal, 0.1; at rest the way down is advance, 0.5 > 0.3.
    InclineCase tried = standard;
    tried.slope = slope;
    tried.speed = -1.0;
    tried.steps = steps;
    const InclineRow row = slide_on_incline(tried);
    const double exact = std::min(0.0, -1.0 + slows * steps * 1e-3);
    thrown_table.rows.push_back({0.3, double(steps), yes_or_no(row.sticks), row.speed, exact});
    thrown_error = std::max(thrown_error, std::abs(row.speed - exact));
    wrong += row.sticks != (exact == 0.0);
  }
  evidence.tables.push_back(std::move(table));
  evidence.tables.push_back(std::move(thrown_table));
  const double down = critical_slope(true, standard), up = critical_slope(false, standard);
  evidence.tables.push_back(
      {"The slope at which the block starts to slide, by bisection",
       {"moves", "tan(slope)", "mu"},
       {{"in", std::tan(down), standard.friction_in}, {"out", std::tan(up), standard.friction_out}}});
  evidence.claim("incline_wrong_states", wrong, 0.0, 0.0, "sticks if and only if tan(slope) <= mu, of its direction");
  evidence.claim("incline_acceleration_error", worst, 0.0, 1e-10,
                 "a constant force in backward Euler is exact: round-off and the iteration's 1e-12 of g");
  evidence.claim("incline_held_acceleration", held, 0.0, 1e-10, "a block that sticks does not creep");
  evidence.claim("incline_thrown_speed_error", thrown_error, 0.0, 1e-10, "the same, and rest after it has stopped");
  evidence.claim("incline_critical_down", std::tan(down) / standard.friction_in - 1.0, -1e-9, 1e-9,
                 "bisection to 1e-12 rad and the iteration's tolerance, 1e-12 of g");
  evidence.claim("incline_critical_up", std::tan(up) / standard.friction_out - 1.0, -1e-9, 1e-9, "the same");
}

void show_stick_slip(Evidence& evidence, bool full) {
  EvidenceTable table{"A needle pulled by a spring of 1e4 N/m at 0.2 m/s, cutting strength 4 N: stick and slip",
                      {"omega tau", "cycles", "period [s]", "exact", "slip [s]", "exact", "drop [N]", "exact",
                       "error of the drop / damping's", "against a scalar block"},
                      {}};
  std::vector<StickSlip> runs;
  double least_rate = std::numeric_limits<double>::infinity(), most_rate = 0.0, least_excess = least_rate,
         most_excess = 0.0, late = 0.0, early = 0.0, scalar = 0.0;
  int others = 0, mismatches = 0, cycles = std::numeric_limits<int>::max();
  std::vector<double> taus{2e-5, 1e-5};
  if (full) taus.insert(taus.end(), {5e-6, 2.5e-6});
  for (const double tau : taus) {
    const StickSlip run = swinging_stick_slip(tau, 4);
    const double rate = (run.drop / run.exact_drop - 1.0) / (run.drop_rate * run.omega_tau);
    table.rows.push_back({run.omega_tau, double(run.cycles), run.period, run.exact_period, run.slip_time,
                          run.exact_slip_time, run.drop, run.exact_drop, rate, run.scalar_difference});
    least_rate = std::min(least_rate, rate);
    most_rate = std::max(most_rate, rate);
    least_excess = std::min(least_excess, run.least_excess);
    most_excess = std::max(most_excess, run.most_excess);
    late = std::max(late, (run.slip_time - run.exact_slip_time) / tau);
    early = std::min(early, (run.slip_time - run.exact_slip_time) / tau);
    scalar = std::max(scalar, run.scalar_difference);
    mismatches += run.scalar_mismatches;
    others += run.other_events;
    cycles = std::min(cycles, run.cycles);
    runs.push_back(run);
  }
  evidence.tables.push_back(std::move(table));
  const StickSlip &fine = runs.back(), &coarse = runs[runs.size() - 2];
  evidence.claim("stick_slip_cycles", cycles, 3.0, 10.0, "cycles that repeat");
  evidence.claim(
      "stick_slip_least_drop_error", least_rate, 0.85, 1.15,
      "over backward Euler's own damping, first order with its constant, less its square; an increment, 9 %");
  evidence.claim("stick_slip_most_drop_error", most_rate, 0.85, 1.15, "the same at every step's length");
  evidence.claim("stick_slip_extrapolated_drop", (2.0 * fine.drop - coarse.drop) / fine.exact_drop - 1.0, -5e-3, 5e-3,
                 "2 (mu_s - mu_k) N to the next order; events come at whole steps, of 0.04 N, 0.5 %");
  evidence.claim("stick_slip_extrapolated_period", (2.0 * fine.period - coarse.period) / fine.exact_period - 1.0, -5e-3,
                 5e-3, "the spring's rise by 2 (mu_s - mu_k) N and half an oscillation; whole steps, 0.4 %");
  evidence.claim("stick_slip_late_steps", late, 0.0, 2.5,
                 "a slip is half an oscillation, found over in the step after it, and longer by its damping");
  evidence.claim("stick_slip_early_steps", early, 0.0, 0.0, "and not less");
  evidence.claim("stick_slip_least_excess", least_excess, -1e-6, 1.0,
                 "it cuts when friction and cutting strength are both exhausted, and not before");
  evidence.claim("stick_slip_most_excess", most_excess, 0.0, 1.0 + 1e-6, "nor later than by a step");
  evidence.claim("stick_slip_other_events", others, 0.0, 0.0, "cut and stick in turn");
  evidence.claim("stick_slip_against_scalar", scalar, 0.0, 1e-4,
                 "one block in the same backward Euler; the needle's own block gives way by 5e-7 of the spring");
  evidence.claim("stick_slip_scalar_mismatches", mismatches, 0.0, 0.0, "it cuts and stops in the same steps");

  const StickSlip creep = creeping_stick_slip(5);
  evidence.tables.push_back(
      {"The same by 1e3 N/m at 5 mm/s, no friction on the shaft, steps far longer than an oscillation",
       {"omega tau", "cycles", "period [s]", "strength / k V", "drop [N]", "strength"},
       {{creep.omega_tau, double(creep.cycles), creep.period, creep.exact_period, creep.drop, creep.exact_drop}}});
  constexpr double step = 0.01;
  const double left = 1.0 / (1.0 + creep.omega_tau * creep.omega_tau);
  evidence.claim("creep_cycles", creep.cycles, 4.0, 10.0, "cycles that repeat");
  evidence.claim("creep_period_late_by_steps", (creep.period - creep.exact_period) / step, 0.0, 2.0,
                 "the drop over k V, and at most the step that passes the threshold and the step of the cut");
  evidence.claim("creep_drop", creep.drop / creep.exact_drop - 1.0, -1.1 * left - 0.0125, 0.0125,
                 "all of the force but 1 / (1 + (omega tau)^2), and the increments of a step, 0.05 N, at cut and end");
  evidence.claim("creep_other_events", creep.other_events, 0.0, 0.0, "cut and stick in turn");
}

void show_channel(Evidence& evidence) {
  const ChannelLoop loop = channel_loop();
  evidence.tables.push_back(
      {"A needle drawn out of a rigid channel by 6 mm and pushed back: work over the closed way [J]",
       {"by the base", "dissipated", "(mu_in + mu_out) p times the mean depth times 6 mm"},
       {{loop.area, loop.dissipated, loop.exact_area}}});
  evidence.tables.push_back(
      {"Its force while it slides, against mu times clamping force",
       {"frames outward", "frames inward", "largest relative difference", "force after / before a reversal",
        "mu_in / mu_out"},
       {{double(loop.sliding_out), double(loop.sliding_in), loop.force_error, loop.at_reversal, -5.0}}});
  evidence.claim("channel_frames_outward", loop.sliding_out, 100.0, 1000.0, "it slid");
  evidence.claim("channel_frames_inward", loop.sliding_in, 50.0, 1000.0, "both ways");
  evidence.claim("channel_force_error", loop.force_error, 0.0, 1e-8,
                 "mu sum N exactly: depth by closest points, 1e-10 of it, and the iteration's tolerance");
  evidence.claim("channel_reversal", loop.at_reversal, -5.15, -5.0,
                 "the sign flips and the coefficient is the other; two steps of 0.1 mm deeper of 14 mm");
  evidence.claim("channel_area_over_dissipated", loop.area / loop.dissipated - 1.0, -1e-9, 1e-9,
                 "the ledger of contact, time integration and the needle's strain; the iteration's tolerance");
  // Friction is that of the depth at a step's start: outward half a step's way more, inward less.
  const double half_step = -(0.5 - 0.1) / (0.5 + 0.1) * 0.5e-4 / (loop.exact_area / (0.6 * 300.0 * 0.006));
  evidence.claim("channel_area_over_exact", loop.area / loop.exact_area - 1.0 - half_step, -2e-4, 2e-4,
                 "less half a step's way, 0.2 %, which backward Euler takes the other coefficient of; needle's strain");
  evidence.claim("channel_ledger_closure", loop.closure, -1e-6, 1e-6, "over in and out until the tip has left");
  evidence.claim("channel_elastic_left", loop.elastic, 0.0, 1e-6, "the needle is as it was");
  evidence.claim("channel_force_left", loop.force_left, 0.0, 0.0, "outside there is none");
  evidence.claim("channel_points_left", loop.points_left, 0.0, 0.0, "nor a row");
}

void show_cycle(Evidence& evidence) {
  const CutCycle cycle = cut_cycle();
  evidence.tables.push_back({"Puncture and cuts of a soft block, thresholds of 5 N and of 5 N and the tip's friction",
                             {"punctures", "cuts", "past the threshold, share of a step's increment: least", "most",
                              "largest increment / threshold", "force two frames after a cut / at it"},
                             {{double(cycle.punctures), double(cycle.cuts), cycle.least_share, cycle.most_share,
                               cycle.largest_increment, cycle.force_after}}});
  evidence.claim("cycle_punctures", cycle.punctures, 1.0, 1.0, "one surface");
  evidence.claim("cycle_cuts", cycle.cuts, 2.0, 20.0, "the force rises again, more than once");
  evidence.claim("cycle_in_order", cycle.in_order ? 1.0 : 0.0, 1.0, 1.0, "touch, puncture, then cut and stick in turn");
  evidence.claim("cycle_least_share", cycle.least_share, 0.0, 1.0, "an event needs its threshold");
  evidence.claim("cycle_most_share", cycle.most_share, 0.0, 1.0, "and comes in the first step that reaches it");
  evidence.claim("cycle_largest_increment", cycle.largest_increment, 0.0, 0.25,
                 "a step is a small part of the threshold, or the two before would say nothing");
  evidence.claim("cycle_force_after", cycle.force_after, 0.0, 0.7, "the force falls after a cut");
  evidence.claim("cycle_risen", cycle.risen, 0.3, 1.0, "and rises before the next");
}

void show_nothing(Evidence& evidence) {
  InsertionSetup setup;
  setup.start_distance = 2e-3;
  setup.estimate_error = true;
  double force = 0.0, moved = 0.0, rows = 0.0, not_finite = 0.0, unconverged = 0.0;
  EvidenceTable table{"A needle outside, no load, no gravity",
                      {"base", "frames", "contact rows", "force [N]", "largest displacement [m]"},
                      {}};
  for (const bool moves : {true, false}) {
    setup.strokes = {{{moves ? 0.012 : 0.0, 0.0, 0.0}, 0.6}};
    const InsertionRun run = run_insertion(setup, 15);  // 1.5 mm of 2 mm
    double run_rows = 0.0, run_force = 0.0;
    for (const InsertionReport& report : run.frames) {
      run_rows += report.contact_points;
      run_force = std::max({run_force, std::abs(report.force), std::abs(report.tip_lateral_force)});
      unconverged += !report.frame.converged;
      // η = 0 / 0 is no number and must not come out as one that is none.
      if (report.frame.eta) not_finite += !std::isfinite(*report.frame.eta);
      not_finite += !std::isfinite(report.base_force) + !std::isfinite(report.frame.residual);
    }
    const double run_moved = run.insertion.tissue.state.u.cwiseAbs().maxCoeff();
    for (const double value : state_values(run.insertion)) not_finite += !std::isfinite(value);
    table.rows.push_back({moves ? "moves" : "rests", double(run.frames.size()), run_rows, run_force, run_moved});
    rows += run_rows;
    force = std::max(force, run_force);
    moved = std::max(moved, run_moved);
  }
  evidence.tables.push_back(std::move(table));
  const std::string reason = "the paper: no interaction force outside; exactly none";
  evidence.claim("outside_rows", rows, 0.0, 0.0, reason);
  evidence.claim("outside_force", force, 0.0, 0.0, reason);
  evidence.claim("outside_displacement", moved, 0.0, 0.0, reason);
  evidence.claim("outside_unconverged_frames", unconverged, 0.0, 0.0, "a system without load is solved by zero");
  evidence.claim("outside_values_not_finite", not_finite, 0.0, 0.0, "and its 0 / 0 are not passed on");
}

}  // namespace

Evidence friction_evidence(const EvidenceOptions& options) {
  static constexpr EvidencePart parts[] = {
      {"a block on an incline", [](Evidence& e, bool) { show_incline(e); }},
      {"stick and slip", show_stick_slip},
      {"a rigid channel", [](Evidence& e, bool) { show_channel(e); }},
      {"puncture and cuts", [](Evidence& e, bool) { show_cycle(e); }},
      {"a needle outside", [](Evidence& e, bool) { show_nothing(e); }},
  };
  return show_parts(parts, options);
}

}  // namespace finegauge
