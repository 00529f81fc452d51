#include "verification/support/interaction_laws.hpp"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <utility>

#include "core/needle/contact_law.hpp"
#include "core/needle/interaction.hpp"

using namespace finegauge;

TEST_CASE("of all sets of open points the one found alone is complementary", "[interaction][unilateral]") {
  NeedleInBoxOptions options;
  options.axial = AxialLaw::unilateral;
  options.lateral = LateralLaw::none;
  options.points = 6;
  options.advance = GENERATE(0.02, 0.002, -0.01);
  CAPTURE(options.advance);
  NeedleInBox box = needle_in_box(options);
  const Interaction found = solve_tightly(box);
  REQUIRE(found.converged);
  const auto [G, r_0] = delassus(dense_interaction(box.system()));
  const int P = options.points;
  int complementary = 0;
  Eigen::VectorXd solution;
  for (int set = 0; set < 1 << P; ++set) {
    std::vector<int> closed;
    for (int p = 0; p < P; ++p)
      if (set >> p & 1) closed.push_back(p);
    Eigen::MatrixXd G_c(closed.size(), closed.size());
    Eigen::VectorXd right(closed.size()), lambda = Eigen::VectorXd::Zero(3 * P);
    for (std::size_t i = 0; i < closed.size(); ++i) {
      right[i] = r_0[3 * closed[i]] + box.points[closed[i]].gap[0] / box.tau;
      for (std::size_t j = 0; j < closed.size(); ++j) G_c(i, j) = G(3 * closed[i], 3 * closed[j]);
    }
    const Eigen::VectorXd lambda_c = closed.empty() ? right : G_c.ldlt().solve(right).eval();
    for (std::size_t i = 0; i < closed.size(); ++i) lambda[3 * closed[i]] = lambda_c[i];
    const Eigen::VectorXd r = r_0 - G * lambda;
    bool good = true;
    for (int p = 0; p < P; ++p)
      good = good && (set >> p & 1 ? lambda[3 * p] > 0.0 : r[3 * p] + box.points[p].gap[0] / box.tau <= 0.0);
    if (!good) continue;
    ++complementary;
    solution = lambda;
  }
  REQUIRE(complementary == 1);
  const int closed = count(found, [](const ContactOutcome& outcome) { return outcome.lambda[0] > 0.0; });
  if (options.advance > 0.0) REQUIRE((closed > 0 && closed < P));
  if (closed > 0)
    CHECK(relative_error(multipliers(found), solution) <= 1e-8);
  else
    CHECK(multipliers(found).isZero(0.0));
}

TEST_CASE("of all combinations of stick and slip the one found alone obeys friction", "[interaction][friction]") {
  NeedleInBoxOptions options;
  options.axial = AxialLaw::friction;
  options.lateral = LateralLaw::none;  // the bounds are p ℓ τ alone
  options.points = 5;
  const auto [advance, clamp] = GENERATE(std::pair{0.02, 0.02}, std::pair{-0.02, 0.03}, std::pair{0.02, 0.3});
  options.advance = advance;
  CAPTURE(advance, clamp);
  NeedleInBox box = needle_in_box(options);
  for (ContactRows& point : box.points) point.clamp *= clamp / 0.002;
  const Interaction found = solve_tightly(box);
  REQUIRE(found.converged);
  const auto [G, r_0] = delassus(dense_interaction(box.system()));
  const int P = options.points;
  int obeys = 0;
  Eigen::VectorXd solution;
  for (int code = 0; code < 243; ++code) {
    std::vector<int> stick;
    Eigen::VectorXd lambda = Eigen::VectorXd::Zero(3 * P);
    std::array<int, 5> state{};
    for (int p = 0, rest = code; p < P; ++p, rest /= 3) {
      state[p] = rest % 3 - 1;
      const double N = box.points[p].clamp * box.tau;
      if (state[p] == 0)
        stick.push_back(p);
      else
        lambda[3 * p] = state[p] > 0 ? box.points[p].friction_in * N : -box.points[p].friction_out * N;
    }
    const Eigen::VectorXd r_fixed = r_0 - G * lambda;
    Eigen::MatrixXd G_s(stick.size(), stick.size());
    Eigen::VectorXd right(stick.size());
    for (std::size_t i = 0; i < stick.size(); ++i) {
      right[i] = r_fixed[3 * stick[i]];
      for (std::size_t j = 0; j < stick.size(); ++j) G_s(i, j) = G(3 * stick[i], 3 * stick[j]);
    }
    const Eigen::VectorXd lambda_s = stick.empty() ? right : G_s.ldlt().solve(right).eval();
    for (std::size_t i = 0; i < stick.size(); ++i) lambda[3 * stick[i]] = lambda_s[i];
    const Eigen::VectorXd r = r_0 - G * lambda;
    bool good = true;
    for (int p = 0; p < P; ++p) {
      const double N = box.points[p].clamp * box.tau;
      good = good && (state[p] == 0 ? lambda[3 * p] <= box.points[p].friction_in * N &&
                                          lambda[3 * p] >= -box.points[p].friction_out * N
                                    : state[p] * r[3 * p] >= 0.0);
    }
    if (!good) continue;
    ++obeys;
    solution = lambda;
  }
  REQUIRE(obeys == 1);
  CHECK(relative_error(multipliers(found), solution) <= 1e-8);
  check_laws(box, found, 1e-8);
  const int sticks = count(found, [](const ContactOutcome& outcome) { return outcome.axial_slip == 0; });
  const int in = count(found, [](const ContactOutcome& outcome) { return outcome.axial_slip == 1; });
  const int out = count(found, [](const ContactOutcome& outcome) { return outcome.axial_slip == -1; });
  CAPTURE(sticks, in, out);
  if (clamp == 0.3)
    CHECK(sticks == P);
  else
    CHECK((advance > 0.0 ? in : out) > 0);
}

TEST_CASE("friction holds, slides in and slides out with the normal force of the side and of the clamp",
          "[interaction][friction]") {
  const double advance = GENERATE(0.5, -0.5, 1e-5);
  CAPTURE(advance);
  NeedleInBoxOptions options;
  options.axial = AxialLaw::friction;
  options.advance = advance;
  options.points = 4;
  NeedleInBox box = needle_in_box(options);
  for (ContactRows& point : box.points) {
    point.gap *= 0.1;
    if (std::abs(advance) < 1e-3) point.clamp = 10.0;
  }
  const Interaction found = solve_tightly(box);
  REQUIRE(found.converged);
  check_laws(box, found, 1e-8);
  double force = 0.0, normal = 0.0;
  for (std::size_t p = 0; p < box.points.size(); ++p) {
    const ContactOutcome& outcome = found.points[p];
    CHECK(outcome.axial_slip == (std::abs(advance) < 1e-3 ? 0 : advance > 0.0 ? 1 : -1));
    CHECK(outcome.lambda.tail<2>().norm() > 0.0);
    CHECK(outcome.lambda[0] * outcome.velocity[0] >= -1e-20);
    force += outcome.lambda[0];
    normal += outcome.lambda.tail<2>().norm() + box.points[p].clamp * box.tau;
  }
  // Whole: as much as all bounds together, and of the sign of the motion.
  if (advance == 0.5) CHECK_THAT(force, WithinRel(0.5 * normal, 1e-14));
  if (advance == -0.5) CHECK_THAT(force, WithinRel(-0.3 * normal, 1e-14));
  if (std::abs(advance) < 1e-3) CHECK(std::abs(force) < 0.3 * normal);
}

TEST_CASE("friction at many points of a cell settles, whatever part of it slides", "[interaction][friction]") {
  // Up to ten points in each of four cells, in which a line has four shapes at most: their rows depend on one another.
  NeedleInBoxOptions options;
  options.axial = AxialLaw::friction;
  options.lateral = LateralLaw::none;
  options.points = GENERATE(10, 20, 40);
  const double clamp = GENERATE(0.03, 1.0, 30.0);
  options.advance = GENERATE(0.02, -0.002);
  CAPTURE(options.points, clamp, options.advance);
  NeedleInBox box = needle_in_box(options);
  for (ContactRows& point : box.points) point.clamp *= clamp;
  InteractionOptions solving;
  solving.iterations = 400;  // 40 points need 241: nearly dependent rows settle slowly
  const Interaction found = solve(box, solving);
  REQUIRE(found.converged);
  // With bounds that are given the laws and the balance are all that there is to know (a convex quadratic program).
  check_laws(box, found, 2e-8);
  check_balance(box, found, 1e-7);
  const int sticks = count(found, [](const ContactOutcome& outcome) { return outcome.axial_slip == 0; });
  if (clamp == 30.0) CHECK(sticks > 0);
  if (clamp == 0.03) CHECK(sticks < options.points);
}

TEST_CASE("points at one place share the friction of one point among them", "[interaction][friction]") {
  NeedleInBoxOptions options;
  options.axial = AxialLaw::friction;
  options.lateral = LateralLaw::none;
  const double clamp = GENERATE(1.0, 10.0, 100.0);
  InteractionOptions solving;
  solving.weight = GENERATE(1e2, 1e4, 1e6);
  CAPTURE(clamp, solving.weight);
  constexpr int copies = 6;
  NeedleInBox box = needle_in_box(options);
  for (ContactRows& point : box.points) point.clamp *= clamp;
  NeedleInBox once = box;
  for (ContactRows& point : once.points) point.clamp *= copies;
  for (int copy = 1; copy < copies; ++copy) box.points.insert(box.points.end(), once.points.begin(), once.points.end());
  for (std::size_t p = 0; p < box.points.size(); ++p) box.points[p].clamp = once.points[p % 5].clamp / copies;
  const Interaction alone = solve(once, solving), together = solve(box, solving);
  REQUIRE(alone.converged);
  REQUIRE(together.converged);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(3 * options.points);
  for (std::size_t p = 0; p < box.points.size(); ++p)
    sum.segment<3>(static_cast<Eigen::Index>(3 * (p % 5))) += together.points[p].lambda;
  CHECK(relative_error(sum, multipliers(alone)) <= 1e-6);
  CHECK((together.tissue - alone.tissue).norm() <= 1e-6 * alone.tissue.norm());
}

TEST_CASE("a slip starts from the last frame's impulse and sticks when the motion turns", "[interaction][friction]") {
  NeedleInBoxOptions options;
  options.axial = AxialLaw::friction;
  options.advance = 0.5;
  NeedleInBox box = needle_in_box(options);
  const Interaction first = solve_tightly(box);
  REQUIRE(first.converged);
  REQUIRE(count(first, [](const ContactOutcome& outcome) { return outcome.axial_slip == 1; }) > 0);
  for (std::size_t p = 0; p < box.points.size(); ++p) box.points[p].lambda = first.points[p].lambda;
  const Interaction again = solve_tightly(box);
  CHECK(again.iterations <= 2);  // one to find that nothing changes, one more for round-off
  CHECK(relative_error(multipliers(again), multipliers(first)) <= 1e-9);

  options.advance = -1e-5;
  NeedleInBox turned = needle_in_box(options);
  for (std::size_t p = 0; p < box.points.size(); ++p) turned.points[p].lambda = first.points[p].lambda;
  for (ContactRows& point : turned.points) point.clamp = 10.0;
  const Interaction stuck = solve_tightly(turned);
  REQUIRE(stuck.converged);
  CHECK(count(stuck, [](const ContactOutcome& outcome) { return outcome.axial_slip == 0; }) == options.points);
  CHECK(relative_error(multipliers(stuck), solve_dense_kkt(turned.system(), stuck).lambda) <= 1e-9);
}

TEST_CASE("a shaft without friction is one without axial rows, to the last bit", "[interaction][friction]") {
  NeedleInBoxOptions options;
  options.axial = AxialLaw::friction;
  options.advance = GENERATE(0.02, -0.02);
  NeedleInBox box = needle_in_box(options);
  for (ContactRows& point : box.points) point.friction_in = point.friction_out = 0.0;
  const Interaction found = solve(box);
  for (ContactRows& point : box.points) point.axial = AxialLaw::none;
  const Interaction without = solve(box);
  REQUIRE(found.converged);
  REQUIRE(multipliers(found).norm() > 0.0);
  CHECK(multipliers(found) == multipliers(without));
  CHECK(found.iterations == without.iterations);
  for (const ContactOutcome& outcome : found.points) CHECK(outcome.axial_slip * outcome.velocity[0] > 0.0);
}

TEST_CASE("a surface point slides at its bound along the velocity, sticks under it and opens",
          "[interaction][coulomb]") {
  NeedleInBoxOptions options;
  options.axial = AxialLaw::unilateral;
  options.lateral = LateralLaw::coulomb;
  options.points = 1;
  options.advance = 0.05;
  options.sideways = {0.08, -0.05};
  const double friction = GENERATE(0.0, 0.1, 5.0);
  CAPTURE(friction);
  NeedleInBox box = needle_in_box(options);
  box.points[0].surface_friction = friction;
  box.points[0].gap.setZero();
  const Interaction found = solve_tightly(box);
  REQUIRE(found.converged);
  REQUIRE(found.points[0].lambda[0] > 0.0);
  CHECK(found.points[0].lateral_slip == (friction < 1.0));
  check_laws(box, found, 1e-8);
  box.points[0].gap[0] = -0.01;  // 1 cm away
  const Interaction open = solve_tightly(box);
  REQUIRE(open.converged);
  CHECK(open.points[0].lambda.isZero(0.0));
  CHECK_FALSE(open.points[0].lateral_slip);
}

TEST_CASE("a point that closes while it slides does not cycle between closed, held and open",
          "[interaction][coulomb]") {
  NeedleInBoxOptions options;  // the second point found this cycle of three when closing points were held first
  options.cells = {4, 3, 3};
  options.needle_modulus = 1e12;
  options.axial = AxialLaw::unilateral;
  options.lateral = LateralLaw::coulomb;
  const NeedleInBox box = needle_in_box(options);
  const Interaction found = solve_tightly(box);
  REQUIRE(found.converged);
  CHECK(found.iterations <= 40);
  CHECK(relative_error(multipliers(found), solve_dense_kkt(box.system(), found).lambda) <= 1e-9);
  check_laws(box, found, 1e-8);
}

TEST_CASE("impulses out of their cone are scaled onto it, from just outside and from far, and others stay to the bit",
          "[interaction]") {
  ContactRows point;
  point.surface_friction = 0.4;
  point.friction_in = 0.5;
  point.friction_out = 0.3;
  point.clamp = 7.0;
  const double tau = 0.01, out = GENERATE(0.0, 0.9, 1.0, 1.001, 1.7, 2.3, 40.0);
  const int side = GENERATE(-1, 1);
  CAPTURE(out, side);
  ContactState state;
  SECTION("Coulomb's law on the surface") {
    point.axial = AxialLaw::unilateral;
    point.lateral = LateralLaw::coulomb;
    const double bound = 0.4 * 3.0;
    const Eigen::Vector2d direction = Eigen::Vector2d(0.6, -0.8 * side);
    state.lambda << 3.0, out * bound * direction;
    const Eigen::Vector3d before = state.lambda;
    clip_to_cone(point, tau, state);
    CHECK(state.lambda[0] == 3.0);
    if (out < 1.0) CHECK(state.lambda == before);
    CHECK((state.lambda.tail<2>() - std::min(out, 1.0) * bound * direction).norm() <= 1e-15 * bound);
    state.lambda[0] = -3.0;  // a surface does not pull, and without pressure there is no friction
    clip_to_cone(point, tau, state);
    CHECK(state.lambda.isZero(0.0));
  }
  SECTION("friction of the shaft") {
    point.axial = AxialLaw::friction;
    point.lateral = LateralLaw::bilateral;
    const double N = 5.0 + 7.0 * tau, bound = side > 0 ? 0.5 * N : -0.3 * N;
    state.lambda << out * bound, 3.0, -4.0;
    clip_to_cone(point, tau, state);
    CHECK(state.lambda.tail<2>() == Eigen::Vector2d(3.0, -4.0));
    CHECK(std::abs(state.lambda[0] - std::min(out, 1.0) * bound) <= 1e-15 * N);
  }
}
