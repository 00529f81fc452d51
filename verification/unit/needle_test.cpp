#include "core/needle/needle.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/needle/rotation_vector.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/central_difference.hpp"
#include "verification/support/insertion_setup.hpp"
#include "verification/support/needle_samples.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

/// Unlike in every direction, so that no term can hide behind a symmetry.
BeamSection uneven_section() {
  BeamSection section;
  section.EA = 40.0;
  section.GA_2 = 9.0;
  section.GA_3 = 14.0;
  section.GJ = 1.7;
  section.EI_2 = 3.0;
  section.EI_3 = 1.1;
  section.mass = 0.3;
  section.polar_inertia = 0.02;
  return section;
}

/// A kinked chain of four elements.
Needle sample_needle() {
  Eigen::Matrix3Xd nodes(3, 5);
  nodes << 0.0, 1.0, 1.9, 2.7, 3.1, 0.0, 0.1, -0.1, 0.3, 1.2, 0.0, 0.0, 0.3, 0.5, 0.7;
  return chain_of_beams(uneven_section(), nodes, {0.1, 0.2, 1.0});
}

/// The whole needle turned by Q about the origin and moved by b.
NeedleState moved(const NeedleState& state, const Eigen::Matrix3d& Q, const Eigen::Vector3d& b) {
  NeedleState result = state;
  result.positions = (Q * state.positions).colwise() + b;
  for (Eigen::Matrix3d& R : result.rotations) R = Q * R;
  return result;
}

NeedleState nudged(const NeedleState& state, Eigen::Index dof, double h) {
  NeedleState result = state;
  displace(h * Eigen::VectorXd::Unit(6 * state.positions.cols(), dof), result);
  return result;
}

}  // namespace

TEST_CASE("forces are the gradient of the energy", "[needle]") {
  std::mt19937 generator(5);
  const Needle needle = sample_needle();
  const double size = GENERATE(0.01, 0.1, 0.3);
  CAPTURE(size);
  const NeedleState state =
      moved(sample_state(needle, size, generator), turn_about_random_axis(4.0, generator), random_vector(generator));
  const Eigen::VectorXd forces = needle_forces(needle, state);
  Eigen::VectorXd gradient(needle.dof_count());
  for (Eigen::Index dof = 0; dof < needle.dof_count(); ++dof)
    gradient[dof] = difference([&](double h) { return needle_energy(needle, nudged(state, dof, h)); }, difference_step);
  REQUIRE(forces.norm() > size);
  // h⁴ times the fifth derivative, largest at large rotations: 1e-12 × 1e3.
  CHECK((forces - gradient).norm() < 1e-9 * forces.norm() / std::min(size, 0.1));
}

TEST_CASE("the tangent is the derivative of the forces, its skew part half the moments", "[needle]") {
  std::mt19937 generator(6);
  const Needle needle = sample_needle();
  const double size = GENERATE(0.0, 0.1, 0.3);
  CAPTURE(size);
  const NeedleState state =
      moved(sample_state(needle, size, generator), turn_about_random_axis(4.0, generator), random_vector(generator));
  const int n = needle.dof_count();
  Eigen::MatrixXd derivative(n, n);
  for (int dof = 0; dof < n; ++dof)
    derivative.col(dof) =
        difference([&](double h) { return needle_forces(needle, nudged(state, dof, h)); }, difference_step);

  const Eigen::VectorXd forces = needle_forces(needle, state);
  Eigen::MatrixXd skew = Eigen::MatrixXd::Zero(n, n), exact = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < needle.node_count(); ++i)
    skew.block<3, 3>(6 * i + 3, 6 * i + 3) = -0.5 * cross_matrix(forces.segment<3>(6 * i + 3));
  for (int e = 0; e < needle.element_count(); ++e)
    exact.block<12, 12>(6 * e, 6 * e) += beam_tangent_stiffness(beam_element(needle, e), beam_nodes(state, e));
  CHECK((exact - derivative).norm() < 1e-9 * derivative.norm());
  CHECK((0.5 * (exact - exact.transpose()) - skew).norm() < 1e-13 * exact.norm());
  if (size > 0.0) CHECK(skew.norm() > 1e-3 * exact.norm());  // so that the sign above was seen

  ChainMatrix K;
  K.set_zero(needle.node_count());
  add_tangent_stiffness(needle, state, 2.0, K);
  CHECK((0.5 * dense(K) - (exact - skew)).norm() < 1e-13 * exact.norm());
  // Without stress there is nothing but the material part; with it they differ.
  ChainMatrix D;
  D.set_zero(needle.node_count());
  add_material_stiffness(needle, state, 2.0, D);
  const double apart = (dense(D) - dense(K)).norm() / dense(K).norm();
  if (size == 0.0)
    CHECK(apart < 1e-13);
  else
    CHECK(apart > 0.01);
}

TEST_CASE("the material stiffness is positive semidefinite under any stress, with the six rigid motions", "[needle]") {
  std::mt19937 generator(7);
  const Needle needle = sample_needle();
  const double size = GENERATE(0.0, 0.3, 0.6);
  CAPTURE(size);
  const NeedleState state = sample_state(needle, size, generator);
  ChainMatrix D;
  D.set_zero(needle.node_count());
  add_material_stiffness(needle, state, 1.0, D);
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense(D)).eigenvalues();
  for (int k = 0; k < 6; ++k) CHECK(std::abs(values[k]) < 1e-14 * values.tail<1>()[0]);
  CHECK(values[6] > 1e-5 * values.tail<1>()[0]);
  // A rigid motion: velocity ω × x and spin ω, or a translation.
  Eigen::VectorXd motion(needle.dof_count()), force;
  const Eigen::Vector3d omega = random_vector(generator), v = random_vector(generator);
  for (int i = 0; i < needle.node_count(); ++i)
    motion.segment<6>(6 * i) << v + omega.cross(state.positions.col(i)), omega;
  multiply(D, motion, force);
  CHECK(force.norm() < 1e-14 * values.tail<1>()[0] * motion.norm());
}

TEST_CASE("a superposed rigid motion leaves the energy and turns the forces, by any angle", "[needle]") {
  std::mt19937 generator(8);
  const Needle needle = sample_needle();
  const NeedleState state = sample_state(needle, 0.2, generator);
  const double energy = needle_energy(needle, state);
  const Eigen::VectorXd forces = needle_forces(needle, state);
  REQUIRE(energy > 0.01);
  for (int k = -8; k <= 8; ++k) {
    const double angle = k * std::numbers::pi / 2.0;  // to two full turns either way, full ones included
    CAPTURE(angle);
    const Eigen::Matrix3d Q = rotation_of(angle * random_vector(generator).normalized());
    const NeedleState turned = moved(state, Q, random_vector(generator));
    CHECK_THAT(needle_energy(needle, turned), WithinRel(energy, 1e-13));
    Eigen::VectorXd expected(forces.size());
    for (Eigen::Index i = 0; i < forces.size(); i += 3) expected.segment<3>(i) = Q * forces.segment<3>(i);
    CHECK((needle_forces(needle, turned) - expected).norm() < 1e-13 * forces.norm());
  }
}

TEST_CASE("internal forces are in balance as a whole", "[needle]") {
  std::mt19937 generator(9);
  const Needle needle = sample_needle();
  const NeedleState state = sample_state(needle, 0.3, generator);
  const Eigen::VectorXd forces = needle_forces(needle, state);
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  for (int i = 0; i < needle.node_count(); ++i) {
    force += forces.segment<3>(6 * i);
    moment += forces.segment<3>(6 * i + 3);
    moment += Eigen::Vector3d(state.positions.col(i)).cross(Eigen::Vector3d(forces.segment<3>(6 * i)));
  }
  CHECK(force.norm() < 1e-14 * forces.norm());
  CHECK(moment.norm() < 1e-14 * forces.norm());
}

TEST_CASE("no way of numbering is preferred: a needle read from the tip has the same energy", "[needle]") {
  std::mt19937 generator(10);
  const Needle needle = sample_needle();
  const NeedleState state = sample_state(needle, 0.3, generator);
  Needle reversed = needle;
  NeedleState reversed_state = state;
  const int n = needle.node_count();
  for (int i = 0; i < n; ++i) {
    reversed.rest_positions.col(i) = needle.rest_positions.col(n - 1 - i);
    reversed_state.positions.col(i) = state.positions.col(n - 1 - i);
    reversed_state.rotations[i] = state.rotations[n - 1 - i];
  }
  const Eigen::Matrix3d half_turn = Eigen::Vector3d(-1.0, 1.0, -1.0).asDiagonal();  // about axis 2
  for (int e = 0; e < n - 1; ++e) reversed.rest_frames[e] = needle.rest_frames[n - 2 - e] * half_turn;
  CHECK_THAT(needle_energy(reversed, reversed_state), WithinRel(needle_energy(needle, state), 1e-13));
}

TEST_CASE("lengths and forces that change by powers of two change no digit", "[needle]") {
  // Length × 2^-10, force × 2^-7: stiffness of sections by force, or force × length².
  std::mt19937 generator(11);
  const Needle needle = sample_needle();
  const NeedleState state = sample_state(needle, 0.3, generator);
  const double length = std::ldexp(1.0, -10), force = std::ldexp(1.0, -7);
  Needle small = needle;
  NeedleState small_state = state;
  small.rest_positions *= length;
  small_state.positions *= length;
  for (BeamSection& s : small.sections) {
    s.EA *= force, s.GA_2 *= force, s.GA_3 *= force;
    s.GJ *= force * length * length, s.EI_2 *= force * length * length, s.EI_3 *= force * length * length;
  }
  CHECK(needle_energy(small, small_state) == needle_energy(needle, state) * force * length);
  const Eigen::VectorXd large_forces = needle_forces(needle, state), small_forces = needle_forces(small, small_state);
  ChainMatrix large_K, small_K;
  large_K.set_zero(needle.node_count());
  small_K.set_zero(needle.node_count());
  add_tangent_stiffness(needle, state, 1.0, large_K);
  add_tangent_stiffness(small, small_state, 1.0, small_K);
  const HeldDofs held = {hold_all, 0, 5, 0, 0};
  hold(held, large_K);
  hold(held, small_K);
  Eigen::VectorXd x = large_forces, y = small_forces;
  ChainFactor(large_K).solve(x);
  ChainFactor(small_K).solve(y);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const bool translation = i % 6 < 3;
    CHECK(small_forces[i] == large_forces[i] * force * (translation ? 1.0 : length));
    // Held entries keep their force in the place of a displacement over a stiffness of its own kind: the same rule.
    CHECK(y[i] == x[i] * (translation ? length : 1.0));
  }
}

TEST_CASE("rotations stay orthonormal over a hundred thousand steps, and turns add up", "[needle]") {
  const Needle needle = sample_needle();
  NeedleState state = needle_at_rest(needle);
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  const int steps = 100000;
  const double tau = 1e-3, rate = 2.0 * std::numbers::pi * 7.0 / (steps * tau);  // seven full turns in all
  for (int i = 0; i < needle.node_count(); ++i) state.spins.col(i) = rate * axis;
  state.velocities.row(1).setConstant(0.25);
  for (int i = 0; i < steps; ++i) advance(tau, state);
  for (const Eigen::Matrix3d& R : state.rotations) {
    // The last step's rounding, whatever came before.
    CHECK((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 2e-15);
    CHECK((R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-10);  // sum of 1e5 roundings
  }
  CHECK((state.positions.row(1) - needle.rest_positions.row(1)).cwiseAbs().maxCoeff() > 24.999);
}

TEST_CASE("mass is that of the needle, and a turning needle carries ½ m v² and ½ J ω²", "[needle]") {
  const NeedleProperties steel;
  const Needle needle = straight_needle(steel, {0.01, 0.0, 0.0}, {0.01, 0.0, 0.1}, 7);
  const double mass = steel.density * std::numbers::pi * 1e-6 * 0.1;
  const Eigen::VectorXd M = needle_mass(needle);
  double sum = 0.0, inertia = 0.0;
  for (int i = 0; i < needle.node_count(); ++i) sum += M[6 * i + 1], inertia += M[6 * i + 5];
  CHECK_THAT(sum, WithinRel(mass, 1e-14));
  CHECK_THAT(inertia, WithinRel(0.5 * mass * 1e-6, 1e-14));  // ½ m r²
  NeedleState state = needle_at_rest(needle);
  state.spins.row(2).setConstant(3.0);  // about z; the axis runs at 10 mm around it
  state.velocities.row(1).setConstant(0.03);
  CHECK_THAT(needle_kinetic_energy(needle, state), WithinRel(0.5 * mass * (9e-4 + 0.5e-6 * 9.0), 1e-13));
}

TEST_CASE("a round section has the areas and moments of a circle", "[needle]") {
  const BeamSection s = round_section({.youngs_modulus = 2.6e9, .poisson_ratio = 0.3, .radius = 2e-3, .density = 1e3});
  const double A = std::numbers::pi * 4e-6, I = std::numbers::pi * 4e-12;
  CHECK_THAT(s.EA, WithinRel(2.6e9 * A, 1e-14));
  CHECK_THAT(s.EI_2, WithinRel(2.6e9 * I, 1e-14));
  CHECK(s.EI_3 == s.EI_2);
  CHECK_THAT(s.GJ, WithinRel(1e9 * 2.0 * I, 1e-14));
  CHECK_THAT(s.GA_2, WithinRel(1e9 * A * 7.8 / 8.8, 1e-14));
  CHECK(s.GA_3 == s.GA_2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(round_section({.youngs_modulus = nan}), std::invalid_argument);
  CHECK_THROWS_AS(round_section({.poisson_ratio = 0.5}), std::invalid_argument);
  CHECK_THROWS_AS(round_section({.radius = 0.0}), std::invalid_argument);
  CHECK_THROWS_AS(round_section({.density = -1.0}), std::invalid_argument);
}

TEST_CASE("chains without length, without elements or along their second axis are refused", "[needle]") {
  CHECK_THROWS_AS(straight_needle({}, {0, 0, 0}, {0, 0, 1}, 0), std::invalid_argument);
  CHECK_THROWS_AS(straight_needle({}, {1, 2, 3}, {1, 2, 3}, 2), std::invalid_argument);
  Eigen::Matrix3Xd nodes = Eigen::Matrix3Xd::Zero(3, 2);
  nodes(0, 1) = 1.0;
  CHECK_THROWS_AS(chain_of_beams(uneven_section(), nodes, {1, 0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(chain_of_beams(uneven_section(), nodes.leftCols<1>(), {0, 1, 0}), std::invalid_argument);
  const Needle along = chain_of_beams(uneven_section(), nodes, {1, 1, 0});
  CHECK((along.rest_frames[0] - Eigen::Matrix3d::Identity()).norm() < 1e-15);
}

TEST_CASE("gravity bends a needle that is held at its base, and its work is what Euler and Bernoulli say",
          "[needle][energy]") {
  InsertionSetup setup;
  setup.cells = {2, 1, 1};
  setup.density = 1e-3;  // of a block that has no part in this
  setup.youngs_modulus = 1e9;
  setup.start_distance = 0.01;  // out of its reach
  setup.strokes.clear();
  InsertionCase made = insertion_case(setup);
  made.problem.drive.guided = false;
  made.problem.motion.tissue.gravity = {0.0, -0.06, -0.08};  // oblique to both axes across
  Insertion insertion = start_insertion(std::move(made.forest), made.problem);
  double at_most = 0.0;
  for (int frame = 0; frame < 80; ++frame) {
    const InsertionReport report = advance_frame(made.problem, insertion);
    REQUIRE(report.frame.converged);
    REQUIRE(report.contact_points == 0);
    at_most = std::max(at_most, std::abs(report.frame.energy.closure));
  }
  // Deflection w L⁴ / 8 E I at the tip, energy stored w² L⁵ / 40 E I; gravity has worked twice that, and what the
  // steps have dissipated is the rest. Shear adds 20 (1 + nu) r² / (6 k L²), 0.5 %; lumped masses some 1/16².
  const double r = setup.needle.radius, L = setup.needle_length, area = std::numbers::pi * r * r;
  const double w = setup.needle.density * area * 0.1, EI = setup.needle.youngs_modulus * 0.25 * area * r * r;
  const double stored = w * w * std::pow(L, 5) / (40.0 * EI);
  const EnergyLedger& energy = insertion.energy;
  CHECK_THAT(energy.elastic, WithinRel(stored, 0.01));
  CHECK_THAT(energy.work, WithinRel(2.0 * stored, 0.01));
  CHECK_THAT(energy.dissipated, WithinRel(stored, 0.02));
  CHECK(energy.kinetic < 1e-6 * stored);
  CHECK(at_most / stored < 1e-6);  // the step is linearized: 2e-7, and a hundred times that at ten times the load
}
