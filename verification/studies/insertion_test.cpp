#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "verification/support/catch.hpp"
#include "verification/support/insertion_setup.hpp"

using namespace finegauge;

namespace {

/// Walls that do not move: every node of a block one cell across is held.
InsertionSetup rigid_channel() {
  InsertionSetup setup;
  setup.cells = {9, 1, 1};
  setup.clamped = {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};
  setup.contact.puncture_strength = 1.0;
  setup.contact.cut_strength = 1.0;
  setup.needle.youngs_modulus = 2e11;
  setup.interaction.tolerance = 1e-11;
  setup.solver.linear.relative_residual = 1e-12;
  // In 20 mm, rest, out until the tip has left.
  setup.strokes = {{{0.02, 0.0, 0.0}, 1.0}, {{0.0, 0.0, 0.0}, 0.2}, {{-0.025, 0.0, 0.0}, 1.25}};
  return setup;
}

const InsertionReport* last_before(const InsertionRun& run, double time) {
  const InsertionReport* found = nullptr;
  for (const InsertionReport& report : run.frames)
    if (report.frame.time < time) found = &report;
  return found;
}

double scaled_difference(const Eigen::MatrixXd& a, double unit, const Eigen::MatrixXd& b) {
  return (a / unit - b).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("the surface gives way within one step's force increment of its strength", "[insertion][puncture]") {
  InsertionSetup setup;
  const InsertionRun run = run_insertion(setup, 60);
  CHECK(run.unconverged() == 0);
  const auto punctures = run.events(ContactEventKind::puncture);
  REQUIRE(punctures.size() == 1);
  const auto at = std::find_if(run.frames.begin(), run.frames.end(), [](const InsertionReport& r) {
    return std::any_of(r.events.begin(), r.events.end(),
                       [](const ContactEvent& e) { return e.kind == ContactEventKind::puncture; });
  });
  REQUIRE(at - run.frames.begin() > 5);  // the force rose over several frames
  const double force = at->tip_force, before = (at - 1)->tip_force, increment = before - (at - 2)->tip_force;
  CHECK(before <= 5.0);
  CHECK(force > 5.0);
  CHECK(increment > 0.0);
  // Rising at an almost constant rate: the excess is at most one increment, with a tenth for its change.
  CHECK(force - 5.0 <= 1.1 * increment);
  // and the force drops after it
  CHECK((at + 2)->force < 0.9 * force);
}

TEST_CASE("outside the tissue there are no rows and no force", "[insertion]") {
  InsertionSetup setup;
  setup.start_distance = 2e-3;
  const InsertionRun run = run_insertion(setup, 15);  // 1.5 mm of 2 mm
  for (const InsertionReport& report : run.frames) {
    CHECK(report.contact_points == 0);
    CHECK(report.force == 0.0);
    CHECK(report.frame.converged);
  }
  CHECK(run.insertion.tissue.state.u.isZero(0.0));
}

TEST_CASE("a tip that ends a frame at the very surface is in balance", "[insertion][newton]") {
  // What it presses with is round-off, 1e-15 N: no share of it can be asked of Newton's iteration.
  InsertionSetup setup;
  setup.step.newton_iterations = 100;
  setup.step.newton_residual = 1e-6;
  setup.strokes = {{{0.012, 0.0, 0.0}, 1.2}};
  setup.time_step = GENERATE(2.5e-3, 5e-3, 1e-2);
  const int frames_to_surface = static_cast<int>(std::lround(setup.start_distance / (0.01 * setup.time_step)));
  const InsertionRun run = run_insertion(setup, frames_to_surface + 3);
  CAPTURE(setup.time_step);
  CHECK(run.unconverged() == 0);
  CHECK(std::abs(run.frames[static_cast<std::size_t>(frames_to_surface) - 1].force) < 1e-12);
  CHECK(run.frames.back().force > 1e-3);
}

TEST_CASE("a rigid channel holds a withdrawn needle by exactly the sum of its friction", "[insertion][friction]") {
  const InsertionSetup setup = rigid_channel();
  const InsertionRun run = run_insertion(setup, 490);
  CHECK(run.unconverged() == 0);
  REQUIRE(run.events(ContactEventKind::exit).size() == 1);
  REQUIRE(run.events(ContactEventKind::retract).size() == 1);
  const double out_time = run.events(ContactEventKind::retract).front().time;
  const double exit_time = run.events(ContactEventKind::exit).front().time;

  int sliding = 0;
  for (const InsertionReport& report : run.frames) {
    if (report.frame.time <= out_time + 0.1 || report.frame.time >= exit_time) continue;
    // The tributary lengths at the start of the step sum to the depth before it: one step's withdrawal more.
    const double depth = (&report - 1)->insertion_depth;
    const double friction = setup.contact.friction_out * setup.contact.clamping * depth;
    CAPTURE(report.frame.time, depth, report.force);
    CHECK_THAT(report.force, WithinRel(-friction, 1e-6));
    ++sliding;
  }
  CHECK(sliding > 50);
  CHECK(last_before(run, 1.0)->force > 0.0);  // the sign flips at reversal
  CHECK(run.frames.back().force == 0.0);
  CHECK(run.frames.back().contact_points == 0);

  // The base's work over the loop is what the contact and the time integration took: the needle is as it was.
  const EnergyLedger& energy = run.insertion.energy;
  CHECK(energy.work > 0.0);
  CHECK(energy.elastic < 1e-6 * energy.work);
  CHECK_THAT(energy.closure, WithinAbs(0.0, 1e-6 * energy.work));
  double area = 0.0, work = 0.0;  // of force over the base's path
  for (std::size_t k = 1; k < run.frames.size(); ++k) {
    const double t0 = run.frames[k - 1].frame.time, t1 = run.frames[k].frame.time;
    const auto x = [&](double t) { return t < 1.0 ? 0.02 * t : t < 1.2 ? 0.02 : 0.02 - 0.02 * (t - 1.2); };
    area += run.frames[k].force * (x(t1) - x(t0));
    work += run.frames[k].base_force * (x(t1) - x(t0));
  }
  CHECK_THAT(work, WithinRel(energy.work, 1e-6));
  // The contact's force differs from the base's by the needle's inertia alone.
  CHECK_THAT(area, WithinRel(energy.work, 1e-2));
}

TEST_CASE("a needle on faces, edges and nodes of the mesh behaves as one beside them", "[insertion]") {
  const bool node_line = GENERATE(true, false);
  InsertionSetup on;
  on.entry = node_line ? Eigen::Vector3d(0.0, 0.01, 0.01) : Eigen::Vector3d(0.0, 0.01, 0.0075);
  InsertionSetup beside = on;
  beside.entry += Eigen::Vector3d(0.0, 1e-9, 1e-9);
  const InsertionRun a = run_insertion(on, 110), b = run_insertion(beside, 110);
  CHECK(a.unconverged() == 0);
  CHECK(b.unconverged() == 0);
  REQUIRE(a.events(ContactEventKind::cut).size() >= 2);
  double largest = 0.0, difference = 0.0;
  for (std::size_t k = 0; k < a.frames.size(); ++k) {
    REQUIRE(a.frames[k].events.size() == b.frames[k].events.size());
    largest = std::max(largest, std::abs(a.frames[k].force));
    difference = std::max(difference, std::abs(a.frames[k].force - b.frames[k].force));
  }
  CHECK(largest > 4.0);
  // 1e-9 m of 2.5 mm cells times a constant of order one, and the solver's tolerance
  CHECK(difference < 1e-5 * largest);
}

TEST_CASE("a needle leaves the body and enters it again", "[insertion]") {
  InsertionSetup setup;
  // Two walls with a gap: cells 3 to 5 along x are missing over the lower half.
  setup.cells = {9, 4, 4};
  setup.removed = RemovedBlock{{3, 0, 0}, {6, 4, 3}};
  // Held on three sides: walls that tilt jam on the shaft, and the force then grows with the base's travel.
  setup.clamped = {"z_max", "y_min", "y_max"};
  setup.needle.youngs_modulus = 2e11;
  setup.strokes = {{{0.030, 0.0, 0.0}, 1.5}, {{-0.035, 0.0, 0.0}, 1.75}};
  const InsertionRun run = run_insertion(setup, 650);
  CHECK(run.unconverged() == 0);
  CHECK(run.events(ContactEventKind::puncture).size() == 2);
  CHECK(run.events(ContactEventKind::exit).size() == 2);  // through the first wall, and at the end
  // In the gap the shaft is clamped over the first wall alone, 13.3 mm, give or take a cut.
  double in_gap = 0.0, deepest = 0.0;
  for (const InsertionReport& report : run.frames) {
    deepest = std::max(deepest, report.insertion_depth);
    if (report.tip_state == TipState::outside) in_gap = std::max(in_gap, report.shaft_force);
  }
  CHECK(in_gap > 0.0);
  CHECK(in_gap < 1.1 * setup.contact.friction_in * setup.contact.clamping * 0.0133);
  CHECK(deepest < 0.0133 + 0.0045);
  CHECK(run.frames.back().contact_points == 0);
  CHECK(run.frames.back().force == 0.0);
}

TEST_CASE("the same insertion ends in the same bits", "[insertion][determinism]") {
  InsertionSetup setup;
  setup.adapt = FrameAdaptRules{};
  const InsertionRun a = run_insertion(setup, 80), b = run_insertion(setup, 80);
  REQUIRE(a.frames.back().frame.cells > a.frames.front().frame.cells);
  CHECK(state_values(a.insertion) == state_values(b.insertion));
}

TEST_CASE("units scaled by powers of two change no bit", "[insertion][units]") {
  InsertionSetup si;
  si.adapt = FrameAdaptRules{};
  InsertionSetup other = si;
  other.units = {8.0, 1.0 / 32.0, 2.0};
  const InsertionRun a = run_insertion(si, 80), b = run_insertion(other, 80);
  const UnitSystem& unit = other.units;
  REQUIRE(a.insertion.tissue.state.u.cols() == b.insertion.tissue.state.u.cols());
  CHECK(a.insertion.tissue.state.u.norm() > 0.0);
  CHECK(scaled_difference(b.insertion.tissue.state.u, unit.length, a.insertion.tissue.state.u) == 0.0);
  CHECK(scaled_difference(b.insertion.tissue.state.v, unit.length / unit.time, a.insertion.tissue.state.v) == 0.0);
  CHECK(scaled_difference(b.insertion.needle.positions, unit.length, a.insertion.needle.positions) == 0.0);
  for (std::size_t k = 0; k < a.frames.size(); ++k) CHECK(b.frames[k].force / unit.force() == a.frames[k].force);
}

TEST_CASE("an insertion in millimetres, grams and seconds is the one in SI", "[insertion][units]") {
  InsertionSetup si;
  InsertionSetup other = si;
  other.units = {1e3, 1e3, 1.0};
  const InsertionRun a = run_insertion(si, 110), b = run_insertion(other, 110);
  double largest = 0.0;
  for (std::size_t k = 0; k < a.frames.size(); ++k) largest = std::max(largest, a.frames[k].force);
  CHECK(largest > 4.0);
  for (std::size_t k = 0; k < a.frames.size(); ++k) {
    REQUIRE(a.frames[k].events.size() == b.frames[k].events.size());
    for (std::size_t e = 0; e < a.frames[k].events.size(); ++e)
      CHECK(a.frames[k].events[e].kind == b.frames[k].events[e].kind);
    CHECK_THAT(b.frames[k].force / other.units.force(), WithinAbs(a.frames[k].force, 1e-6 * largest));
  }
}

namespace {

/// Static equilibrium of tissue and needle bound together as they are now, from the undeformed state, as one dense
/// system in positions: K u + Jᵀ F = 0 with linear tissue, and the needle linear about its present, straight
/// configuration. Returns the axial force of all rows on the x axis [N].
double bound_static_force(const InsertionSetup& setup, Insertion& insertion) {
  InsertionCase made = insertion_case(setup);
  const InsertionProblem& problem = made.problem;
  const TissueMesh& mesh = insertion.tissue.mesh;
  const int n = mesh.d.dof_count(), m = problem.needle.dof_count();

  BlockMatrix<double> K_t = assemble_stiffness(mesh.d, insertion.tissue.state.u);
  apply_supports(mesh.d.supports, K_t);
  ChainMatrix K_n;
  K_n.set_zero(problem.needle.node_count());
  add_material_stiffness(problem.needle, insertion.needle, 1.0, K_n);
  const Eigen::VectorXd needle_forces_now = needle_forces(problem.needle, insertion.needle);

  const double tau = problem.motion.time_step;
  const TissueView view{insertion.tissue.forest, mesh.d.mesh, mesh.d.hanging, insertion.tissue.state.u,
                        insertion.tissue.state.v};
  NeedleContacts contacts = insertion.contacts;
  const auto rows = contacts.begin_step(problem.needle, insertion.needle, view, Eigen::Vector3d::Zero(),
                                        Eigen::Matrix3d::Identity(), tau);
  const int r = 3 * static_cast<int>(rows.size());
  // Unknowns: tissue displacement from rest, needle displacement from now, forces. All rows bind: along the needle at
  // the offset that insertion left (stick), across it with no gap.
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n + m + r, n + m + r);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n + m + r);
  A.topLeftCorner(n, n) = Eigen::MatrixXd(to_sparse(K_t));
  for (int i = 0; i < problem.needle.node_count(); ++i) {
    A.block<6, 6>(n + 6 * i, n + 6 * i) = K_n.diagonal[i];
    if (i + 1 == problem.needle.node_count()) continue;
    A.block<6, 6>(n + 6 * i, n + 6 * i + 6) = K_n.upper[i];
    A.block<6, 6>(n + 6 * i + 6, n + 6 * i) = K_n.upper[i].transpose();
  }
  b.segment(n, m) = -needle_forces_now;
  for (std::size_t p = 0; p < rows.size(); ++p) {
    Eigen::Vector3d tissue_now = Eigen::Vector3d::Zero();
    const Eigen::VectorXd u = gather(mesh.d.hanging, insertion.tissue.state.u);
    for (std::size_t i = 0; i < rows[p].tissue.node.size(); ++i)
      tissue_now += rows[p].tissue.weight[i] * u.segment<3>(3 * rows[p].tissue.node[i]);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d f = rows[p].frame.col(k);
      const int at = n + m + 3 * static_cast<int>(p) + k;
      Eigen::VectorXd J = Eigen::VectorXd::Zero(n + m);
      Eigen::VectorXd J_t = Eigen::VectorXd::Zero(n);
      for (std::size_t i = 0; i < rows[p].tissue.node.size(); ++i)
        J_t.segment<3>(3 * rows[p].tissue.node[i]) -= rows[p].tissue.weight[i] * f;
      project(mesh.d.supports, J_t);
      J.head(n) = J_t;
      J.segment<12>(n + 6 * rows[p].element) = rows[p].needle.transpose() * f;
      A.block(at, 0, 1, n + m) = J.transpose();
      A.block(0, at, n + m, 1) = J;
      // Relative position now is N δ_n + x_n - x_t(u); it shall be what it is now along n, zero across.
      b[at] = -f.dot(tissue_now) - (k == 0 ? 0.0 : rows[p].gap[k]);
    }
  }
  // The base and the guided nodes are held where they are.
  const double entry = contacts.entry_length(problem.needle), element = setup.needle_length / setup.elements;
  for (int node = 0; node < problem.needle.node_count(); ++node)
    for (int k = 0; k < 6; ++k) {
      const bool guided = node > 0 && node * element <= entry - element && (k == 1 || k == 2);
      if (node != 0 && !guided) continue;
      A.row(n + 6 * node + k).setZero();
      A.col(n + 6 * node + k).setZero();
      A(n + 6 * node + k, n + 6 * node + k) = 1.0;
      b[n + 6 * node + k] = 0.0;
    }
  // Rows that the frame left out hold nothing here either.
  for (std::size_t p = 0; p < rows.size(); ++p)
    for (int k = 1; k < 3; ++k) {
      if (rows[p].lateral != LateralLaw::none) continue;
      const int at = n + m + 3 * static_cast<int>(p) + k;
      A.row(at).setZero();
      A.col(at).setZero();
      A(at, at) = 1.0;
      b[at] = 0.0;
    }
  const Eigen::VectorXd x = A.fullPivLu().solve(b);
  double force = 0.0;
  for (std::size_t p = 0; p < rows.size(); ++p) force += x[n + m + 3 * static_cast<int>(p)] * rows[p].frame(0, 0);
  return force;
}

}  // namespace

TEST_CASE("the force held after a puncture is that of the bound static problem", "[insertion][kkt]") {
  const InsertionSetup setup = held_insertion();
  InsertionRun run = run_insertion(setup, 500);
  CHECK(run.unconverged() == 0);
  REQUIRE(run.events(ContactEventKind::puncture).size() == 1);
  const InsertionReport& end = run.frames.back();
  REQUIRE(end.force > 0.5);
  REQUIRE(end.contact_points >= 3);
  REQUIRE(run.events(ContactEventKind::cut).size() >= 2);
  REQUIRE(end.frame.energy.kinetic < 1e-12 * end.frame.energy.elastic);
  CHECK_THAT(bound_static_force(setup, run.insertion), WithinRel(end.force, 1e-6));
}

TEST_CASE("a needle off the middle slides on a coarse mesh as on fine ones", "[insertion][friction]") {
  // Points two millimetres apart in cells of five: rows nearer than half a cell would lock the shaft.
  InsertionSetup coarse;
  coarse.entry = {0.0, 0.01, 0.006};
  coarse.needle.youngs_modulus = 2e11;
  coarse.strokes = {{{0.016, 0.0, 0.0}, 1.6}};
  InsertionSetup fine = coarse;
  fine.cells = {18, 8, 8};
  const InsertionRun a = run_insertion(coarse, 320), b = run_insertion(fine, 320);
  CHECK(a.unconverged() == 0);
  CHECK(b.unconverged() == 0);
  REQUIRE(b.frames.back().shaft_force > 1.0);
  CHECK_THAT(a.frames.back().shaft_force, WithinRel(b.frames.back().shaft_force, 0.1));
}

TEST_CASE("a surface that the tip is moved into sideways is met", "[insertion]") {
  InsertionSetup setup;
  setup.needle.youngs_modulus = 2e11;
  setup.start_distance = -0.005;  // the tip is past the front face, beside the block
  setup.entry = {0.0, -0.0012, 0.01};
  setup.contact.puncture_strength = 1e3;
  setup.strokes = {{{0.0, 0.002, 0.0}, 0.4}};
  const InsertionRun run = run_insertion(setup, 80);
  CHECK_FALSE(run.events(ContactEventKind::touch).empty());
  CHECK(run.frames.back().contact_points == 1);
  // 0.8 mm past the face: held out by it, and the block gives way
  CHECK(run.insertion.tissue.state.u.row(1).maxCoeff() > 1e-5);
}
