#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/needle/centreline.hpp"
#include "core/space/assembly.hpp"
#include "verification/studies/friction_evidence.hpp"
#include "verification/support/insertion_setup.hpp"

namespace finegauge {

namespace {

using std::numbers::pi;

const std::vector<std::string> all_sides{"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};

[[noreturn]] void not_converged(const char* where) {
  throw std::runtime_error(std::string(where) + ": a frame did not converge");
}

/// Walls that do not move: every node of a block one cell across is held.
InsertionSetup rigid_channel() {
  InsertionSetup setup;
  setup.cells = {9, 1, 1};
  setup.clamped = all_sides;
  setup.contact.puncture_strength = 1.0;
  setup.contact.cut_strength = 1.0;
  setup.needle.youngs_modulus = 2e11;
  setup.interaction.tolerance = 1e-11;
  setup.solver.linear.relative_residual = 1e-12;
  return setup;
}

/// A soft element before a stiff one, as a mass on a spring.
struct SpringNeedle {
  Needle needle;
  double k = 0.0, mass = 0.0;  ///< [N/m], [kg]
};
SpringNeedle spring_needle(double k, double tip_x) {
  constexpr double block = 0.032, spring = 0.01;  // [m]
  Eigen::Matrix3Xd nodes(3, 3);
  nodes.row(0) << tip_x - block - spring, tip_x - block, tip_x;
  nodes.bottomRows<2>().setConstant(0.01);
  SpringNeedle result{chain_of_beams(round_section({}), nodes, Eigen::Vector3d::UnitY()), k, 0.0};
  result.needle.sections[0].EA = k * spring;
  result.needle.sections[1].EA *= 1e3;
  // Of a round bar; half of the spring's is at its moving end.
  const NeedleProperties steel;
  result.mass = steel.density * pi * steel.radius * steel.radius * (block + 0.5 * spring);
  return result;
}

struct SpringRun {
  std::vector<InsertionReport> frames;
  double tau = 0.0;
};

bool has(const InsertionReport& report, ContactEventKind kind) {
  return std::ranges::any_of(report.events, [&](const ContactEvent& event) { return event.kind == kind; });
}

/// Whether the block, in motion before, stands in the frame `at`. Not the event "stick", which comes when the
/// tip's speed is none to the tolerance of the solve.
bool stands(const SpringRun& run, std::size_t at, double V) {
  return run.frames[at].insertion_depth - run.frames[at - 1].insertion_depth < 1e-3 * V * run.tau;
}

/// Means over the cycles from the first cut on, and the excess of the spring's force at the cuts.
void measure(const SpringRun& run, double k, double V, double threshold, double friction_per_depth, StickSlip& result) {
  double last_cut = 0.0, force_at_cut = 0.0, periods = 0.0, slips = 0.0, drops = 0.0;
  int slip_count = 0;
  bool slipping = false;
  result.least_excess = std::numeric_limits<double>::infinity();
  result.most_excess = -result.least_excess;
  for (std::size_t at = 1; at < run.frames.size(); ++at) {
    const InsertionReport& report = run.frames[at];
    const double time = report.frame.time;
    if (slipping && stands(run, at, V)) {
      slips += time - last_cut;
      drops += force_at_cut - report.base_force;
      ++slip_count;
      slipping = false;
    }
    if (has(report, ContactEventKind::cut)) {
      if (last_cut > 0.0) {
        periods += time - last_cut;
        ++result.cycles;
      }
      last_cut = time;
      force_at_cut = report.base_force;
      slipping = true;
      // Friction is that of the depth at the step's start.
      const double needed = threshold + friction_per_depth * run.frames[at - 1].insertion_depth;
      const double excess = (report.base_force - needed) / (k * V * run.tau);
      result.least_excess = std::min(result.least_excess, excess);
      result.most_excess = std::max(result.most_excess, excess);
    }
    for (const ContactEvent& event : report.events)
      result.other_events += event.kind != ContactEventKind::cut && event.kind != ContactEventKind::stick &&
                             event.kind != ContactEventKind::slip;
  }
  result.period = periods / result.cycles;
  result.slip_time = slips / slip_count;
  result.drop = drops / slip_count;
}

/// The block alone from the run's first cut on: v⁺ = v + τ/m (F + k V τ - k τ v⁺ - friction), friction of the depth at
/// the step's start; stops where it would go back, cuts where the spring holds cutting strength and friction.
void compare_with_scalar(const SpringRun& run, const SpringNeedle& block, double V, double cut, double c,
                         StickSlip& result) {
  std::size_t at = 0;
  while (at < run.frames.size() && !has(run.frames[at], ContactEventKind::cut)) ++at;
  if (at == run.frames.size()) throw std::runtime_error("stick-slip: no cut");
  const double tau = run.tau, k = block.k;
  double force = run.frames[at].base_force, depth = run.frames[at].insertion_depth, v = 0.0;
  bool slips = true;
  for (++at; at < run.frames.size(); ++at) {
    bool cuts = false, stops = false;
    if (slips) {
      v = (v + tau / block.mass * (force + k * V * tau - c * depth)) / (1.0 + k * tau * tau / block.mass);
      stops = v <= 0.0;
      if (stops) v = 0.0;
    }
    force += k * tau * (V - v);
    if (!slips) cuts = force >= cut + c * depth;
    depth += tau * v;
    slips = cuts || (slips && !stops);
    result.scalar_difference = std::max(result.scalar_difference, std::abs(run.frames[at].base_force - force) / cut);
    result.scalar_mismatches += has(run.frames[at], ContactEventKind::cut) != cuts || (stops && !stands(run, at, V));
  }
}

}  // namespace

InclineRow slide_on_incline(const InclineCase& the_case) {
  // One cell, all of it held: the channel.
  BoxMeshOptions box;
  box.size = {0.1, 0.1, 0.1};
  box.cells = {1, 1, 1};
  const RefinementForest forest(box_mesh(box));
  std::vector<SupportCondition> supports;
  for (const std::string& side : all_sides) supports.push_back({side, {}, {}, {}});
  const Discretization d = discretize(forest, {.youngs_modulus = 1e6, .poisson_ratio = 0.3}, supports);
  BlockMatrix<double> A = assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
  apply_supports(d.supports, A);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(d.dof_count());

  const Needle needle = straight_needle({}, {0.02, 0.05, 0.05}, {0.06, 0.05, 0.05}, 1);
  const Eigen::VectorXd mass = needle_mass(needle);
  NeedleState state = needle_at_rest(needle);
  state.velocities.row(0).setConstant(the_case.speed);
  const HeldDofs free(needle.node_count(), 0u);
  const Eigen::Vector3d g = gravity * Eigen::Vector3d(std::sin(the_case.slope), 0.0, -std::cos(the_case.slope));
  constexpr double tau = 1e-3;  // [s]
  std::vector<ContactRows> rows(2);
  for (int end = 0; end < 2; ++end) {
    ContactRows& row = rows[end];
    // The channel's points need not follow the block: it is the same everywhere.
    const auto place = locate_at_rest(forest.base(), needle.rest_positions.col(end));
    find_reduced_weights(forest, d.mesh, d.hanging,
                         spread_over_ring(forest.base(), place.value(), Eigen::Vector3d::UnitX(), 0.0), row.tissue);
    row.needle = centreline_velocity(needle, state, {0, static_cast<double>(end)});
    row.frame = Eigen::Matrix3d::Identity();
    row.axial = AxialLaw::friction;
    row.lateral = LateralLaw::bilateral;
    row.friction_in = the_case.friction_in;
    row.friction_out = the_case.friction_out;
  }
  InteractionOptions options;
  options.tolerance = 1e-12;
  StepSolver solver;
  solver.set_matrix(A, false);
  InclineRow result;
  for (int step = 0; step < the_case.steps; ++step) {
    const Eigen::VectorXd v = generalized_velocity(state);
    ChainMatrix K;
    K.set_zero(needle.node_count());
    add_material_stiffness(needle, state, tau * tau, K);
    Eigen::VectorXd b;
    multiply(K, v, b);
    b = -b - tau * needle_forces(needle, state);
    for (int node = 0; node < needle.node_count(); ++node) {
      b.segment<3>(6 * node) += tau * mass[6 * node] * g;
      K.diagonal[node].diagonal() += mass.segment<6>(6 * node);
    }
    const Interaction found = solve_interaction({.A = A,
                                                 .b = none,
                                                 .supports = d.supports,
                                                 .tissue_velocity = none,
                                                 .needle_A = K,
                                                 .needle_b = b,
                                                 .held = free,
                                                 .needle_velocity = v,
                                                 .points = rows,
                                                 .tau = tau,
                                                 .reference_speed = gravity * tau},
                                                options, solver);
    if (!found.converged) not_converged("incline");
    set_generalized_velocity(v + found.needle, state);
    advance(tau, state);
    result.sticks = true;
    for (std::size_t p = 0; p < rows.size(); ++p) {
      rows[p].lambda = found.points[p].lambda;
      result.sticks = result.sticks && found.points[p].axial_slip == 0;
    }
  }
  result.speed = state.velocities.row(0).mean();
  result.acceleration = (result.speed - the_case.speed) / (the_case.steps * tau);
  return result;
}

double critical_slope(bool down, const InclineCase& the_case) {
  double holds = 0.0, slides = 1.5;
  while (slides - holds > 1e-12) {
    InclineCase tried = the_case;
    const double slope = 0.5 * (holds + slides);
    tried.slope = down ? slope : -slope;
    tried.steps = 3;
    (slide_on_incline(tried).sticks ? holds : slides) = slope;
  }
  return 0.5 * (holds + slides);
}

StickSlip swinging_stick_slip(double tau, int cycles) {
  // 4 N to cut are 0.4 mm of the spring; the shaft's friction at 13 mm is 3.9 N. The length of a cut, 12 mm, is that of
  // a dozen slips, so that each of them ends where the block stops.
  constexpr double k = 1e4, V = 0.2, cut = 4.0, coarse = 1e-3, depth = 0.013;
  InsertionSetup setup = rigid_channel();
  setup.contact.puncture_strength = 0.1;
  setup.contact.cut_strength = cut;
  setup.contact.cut_advance = 0.012;
  setup.contact.clamping = 600.0;
  const double c = setup.contact.friction_in * setup.contact.clamping;  // friction per depth [N/m]
  const double reach = setup.start_distance + depth;
  setup.strokes = {{{0.03, 0.0, 0.0}, 0.03 / V}};
  setup.time_step = coarse;
  InsertionCase made = insertion_case(setup);
  SpringNeedle needle = spring_needle(k, -setup.start_distance);
  made.problem.needle = needle.needle;
  Insertion insertion = start_insertion(std::move(made.forest), made.problem);
  // To the depth in long steps; the frames then go on counting in short ones.
  for (int frame = 0; frame < static_cast<int>(std::ceil(reach / V / coarse)); ++frame)
    if (!advance_frame(made.problem, insertion).frame.converged) not_converged("stick-slip, way in");
  made.problem.motion.time_step = tau;
  insertion.tissue.frame = static_cast<int>(std::lround(insertion.tissue.time / tau));

  // The slip from the threshold, v = 0: m x'' = cut + k V t - (k + c) x, until it stops; then the spring's force has to
  // rise by 2 cut.
  StickSlip result;
  const double omega = std::sqrt((k + c) / needle.mass), ratio = cut * omega / (k * V);
  const double phase = 2.0 * (pi - std::atan(ratio));
  result.omega_tau = omega * tau;
  result.exact_slip_time = phase / omega;
  result.exact_period = result.exact_slip_time + 2.0 * cut / (k * V);
  const double slip = (2.0 * cut + k * V * result.exact_slip_time) / (k + c);
  result.exact_drop = k * (slip - V * result.exact_slip_time);
  // Backward Euler shrinks the oscillation by 1 - ωτ/2 per radian; it stops where the speed is that of the base.
  result.drop_rate = -0.25 * phase * (1.0 + 1.0 / (ratio * ratio));

  // One cycle passes before the first whole one.
  SpringRun run{{}, tau};
  const int frames = static_cast<int>((cycles + 1.5) * result.exact_period / tau);
  int cuts = 0;
  for (int frame = 0; frame < frames; ++frame) {
    InsertionReport report = advance_frame(made.problem, insertion);
    if (!report.frame.converged) not_converged("stick-slip");
    for (const ContactEvent& event : report.events) cuts += event.kind == ContactEventKind::cut;
    if (cuts > 0 || frame * tau > result.exact_period) run.frames.push_back(std::move(report));
  }
  measure(run, k, V, cut, c, result);
  compare_with_scalar(run, needle, V, cut, c, result);
  return result;
}

StickSlip creeping_stick_slip(int cycles) {
  constexpr double k = 1e3, V = 0.005, cut = 4.0;
  InsertionSetup setup = rigid_channel();
  setup.contact.puncture_strength = 0.1;
  setup.contact.cut_strength = cut;
  setup.contact.cut_advance = 1e-3;
  setup.contact.clamping = 0.0;
  setup.time_step = 0.01;
  setup.strokes = {{{0.04, 0.0, 0.0}, 0.04 / V}};
  InsertionCase made = insertion_case(setup);
  const SpringNeedle needle = spring_needle(k, -setup.start_distance);
  made.problem.needle = needle.needle;
  Insertion insertion = start_insertion(std::move(made.forest), made.problem);
  StickSlip result;
  result.omega_tau = std::sqrt(k / needle.mass) * setup.time_step;
  result.exact_period = cut / (k * V);
  result.exact_slip_time = 0.0;
  result.exact_drop = cut;
  SpringRun run{{}, setup.time_step};
  const int frames =
      static_cast<int>(((cycles + 1.2) * result.exact_period + setup.start_distance / V) / setup.time_step);
  bool cut_once = false;
  for (int frame = 0; frame < frames; ++frame) {
    InsertionReport report = advance_frame(made.problem, insertion);
    if (!report.frame.converged) not_converged("creeping stick-slip");
    for (const ContactEvent& event : report.events) cut_once = cut_once || event.kind == ContactEventKind::cut;
    run.frames.push_back(std::move(report));
    if (!cut_once) run.frames.erase(run.frames.begin(), run.frames.end() - 1);
  }
  measure(run, k, V, cut, 0.0, result);
  return result;
}

ChannelLoop channel_loop() {
  InsertionSetup setup = rigid_channel();
  setup.contact.friction_in = 0.5;
  setup.contact.friction_out = 0.1;
  constexpr double way = 0.006;
  setup.strokes = {{{0.02, 0.0, 0.0}, 1.0},
                   {{0.0, 0.0, 0.0}, 0.1},
                   {{-way, 0.0, 0.0}, 0.3},
                   {{way, 0.0, 0.0}, 0.3},
                   {{-0.025, 0.0, 0.0}, 1.25}};
  constexpr double out = 1.1, back = 1.4, end = 1.7;  // when the loop starts, turns and is closed [s]
  const InsertionCase made = insertion_case(setup);
  const InsertionRun run = run_insertion(setup, 592);
  if (run.unconverged() > 0) not_converged("channel");
  const auto x = [&](double t) { return base_displacement(made.problem.drive, t).x(); };
  const double p = setup.contact.clamping, mu_in = setup.contact.friction_in, mu_out = setup.contact.friction_out;
  ChannelLoop result;
  double exit_time = 0.0, depth = 0.0, taken = 0.0, before_reversal = 0.0, after_reversal = 0.0;
  for (const ContactEvent& event : run.events(ContactEventKind::exit)) exit_time = event.time;
  for (std::size_t k = 1; k < run.frames.size(); ++k) {
    const InsertionReport &before = run.frames[k - 1], &now = run.frames[k];
    const EnergyLedger& energy = now.frame.energy;
    const double t = now.frame.time, slack = 1e-9;
    // The first steps of a stroke turn the needle's strain around; the last of the way in meets the channel's bottom.
    const bool outward = (t > out + 0.01 && t < back + slack) || (t > end + 0.01 && t < exit_time - slack);
    const bool inward = t > back + 0.01 && t < end - 0.01;
    if (outward || inward) {
      const double expected = (outward ? -mu_out : mu_in) * p * before.insertion_depth;
      result.force_error = std::max(result.force_error, std::abs(now.force / expected - 1.0));
      ++(outward ? result.sliding_out : result.sliding_in);
    }
    if (t > out + slack && t < end + slack) result.area += now.base_force * (x(t) - x(before.frame.time));
    const double accounted = energy.dissipated + energy.kinetic + energy.elastic;
    if (std::abs(t - out) < slack) {
      taken = accounted;
      depth = now.insertion_depth;
    }
    if (std::abs(t - back) < slack) before_reversal = now.force;
    if (std::abs(t - (back + 0.02)) < slack) after_reversal = now.force;
    if (std::abs(t - end) < slack) result.dissipated = accounted - taken;
  }
  result.at_reversal = after_reversal / before_reversal;
  result.exact_area = (mu_in + mu_out) * p * (depth * way - 0.5 * way * way);
  const EnergyLedger& energy = run.insertion.energy;
  result.closure = energy.closure / energy.work;
  result.elastic = energy.elastic / energy.work;
  result.force_left = run.frames.back().force;
  result.points_left = run.frames.back().contact_points;
  return result;
}

CutCycle cut_cycle() {
  InsertionSetup setup;
  setup.contact.puncture_strength = 4.0;
  const InsertionRun run = run_insertion(setup, 125);
  if (run.unconverged() > 0) not_converged("puncture and cuts");
  CutCycle result;
  result.least_share = result.risen = std::numeric_limits<double>::infinity();
  result.most_share = -result.least_share;
  result.in_order = true;
  ContactEventKind expected = ContactEventKind::touch;
  double lowest = std::numeric_limits<double>::infinity();  // force since the last cut
  for (std::size_t k = 2; k < run.frames.size(); ++k) {
    const InsertionReport& report = run.frames[k];
    lowest = std::min(lowest, report.force);
    for (const ContactEvent& event : report.events) {
      if (event.kind == ContactEventKind::slip) continue;  // of the shaft
      result.in_order = result.in_order && event.kind == expected;
      expected = event.kind == ContactEventKind::touch      ? ContactEventKind::puncture
                 : event.kind == ContactEventKind::puncture ? ContactEventKind::cut
                 : event.kind == ContactEventKind::cut      ? ContactEventKind::stick
                                                            : ContactEventKind::cut;
      const bool puncture = event.kind == ContactEventKind::puncture;
      if (!puncture && event.kind != ContactEventKind::cut) continue;
      const ContactRules& rules = setup.contact;
      const double threshold =
          puncture ? rules.puncture_strength : rules.cut_strength + rules.friction_in * report.tip_lateral_force;
      const double force = report.tip_force, increment = force - run.frames[k - 1].tip_force;
      result.least_share = std::min(result.least_share, (force - threshold) / increment);
      result.most_share = std::max(result.most_share, (force - threshold) / increment);
      result.largest_increment = std::max(result.largest_increment, increment / threshold);
      ++(puncture ? result.punctures : result.cuts);
      if (puncture) continue;
      if (k + 2 < run.frames.size())
        result.force_after = std::max(result.force_after, run.frames[k + 2].force / report.force);
      if (std::isfinite(lowest)) result.risen = std::min(result.risen, (report.force - lowest) / report.force);
      lowest = std::numeric_limits<double>::infinity();
    }
  }
  return result;
}

}  // namespace finegauge
