#include "core/needle/interaction.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "verification/support/catch.hpp"
#include "verification/support/dense_kkt.hpp"
#include "verification/support/needle_in_box.hpp"

using namespace finegauge;

namespace {

Interaction solve(const NeedleInBox& box, const InteractionOptions& options = {},
                  const StepSolverOptions& solver_options = {}) {
  StepSolver solver(solver_options);
  solver.set_matrix(box.A, false);
  return solve_interaction(box.system(), options, solver);
}

/// Tolerances below what the tests compare to.
Interaction solve_tightly(const NeedleInBox& box, StepMethod method = StepMethod::kept) {
  InteractionOptions options;
  options.tolerance = 1e-10;
  return solve(box, options, {method, {1e-11, 4000}});
}

double relative_error(const Eigen::VectorXd& value, const Eigen::VectorXd& exact) {
  return (value - exact).norm() / exact.norm();
}

int count(const Interaction& found, bool (*is)(const ContactOutcome&)) {
  return static_cast<int>(std::count_if(found.points.begin(), found.points.end(), is));
}

/// The laws of contact_rows.hpp at every point, within `slack` of λ's scale and of the reference speed.
void check_laws(const NeedleInBox& box, const Interaction& found, double slack) {
  const double impulse = slack * multipliers(found).cwiseAbs().maxCoeff(), speed = slack * box.reference_speed;
  for (std::size_t p = 0; p < box.points.size(); ++p) {
    CAPTURE(p);
    const ContactRows& point = box.points[p];
    const auto& [lambda, r, axial_slip, lateral_slip] = found.points[p];
    const Eigen::Vector3d closing = r + point.gap / box.tau;
    const double across = lambda.tail<2>().norm();
    if (point.lateral == LateralLaw::none) CHECK(across == 0.0);
    if (point.axial == AxialLaw::bilateral) CHECK(std::abs(closing[0]) <= speed);
    if (point.lateral == LateralLaw::bilateral) CHECK(closing.tail<2>().norm() <= 2.0 * speed);
    if (point.axial == AxialLaw::unilateral) {
      CHECK(lambda[0] >= 0.0);
      CHECK(closing[0] <= speed);
      CHECK((lambda[0] == 0.0 || closing[0] >= -speed));
    }
    if (point.axial == AxialLaw::friction) {
      const double N = across + point.clamp * box.tau;
      CHECK(lambda[0] <= point.friction_in * N + impulse);
      CHECK(lambda[0] >= -point.friction_out * N - impulse);
      if (axial_slip == 0) CHECK(std::abs(r[0]) <= speed);
      // A slip: on the bound to the last bit, and it dissipates.
      if (axial_slip == 1) CHECK(lambda[0] == point.friction_in * N);
      if (axial_slip == -1) CHECK(lambda[0] == -(point.friction_out * N));
      CHECK(axial_slip * r[0] >= -speed);
    }
    if (point.lateral == LateralLaw::coulomb) {
      const double bound = point.surface_friction * std::max(lambda[0], 0.0);
      CHECK(across <= bound * (1.0 + 1e-14) + (lateral_slip ? 0.0 : impulse));
      if (lateral_slip) {
        CHECK_THAT(across, WithinRel(bound, 1e-14));
        // Along the velocity, of its sign: positive impulses push the needle back.
        CHECK(lambda.tail<2>().dot(r.tail<2>()) >= (1.0 - 1e-6) * across * r.tail<2>().norm());
      } else if (lambda[0] > 0.0) {
        CHECK(r.tail<2>().norm() <= 2.0 * speed);
      }
    }
  }
}

/// Both momentum balances with the multipliers returned.
void check_balance(const NeedleInBox& box, const Interaction& found, double tolerance) {
  const DenseInteraction dense = dense_interaction(box.system());
  Eigen::VectorXd dv(dense.b.size());
  dv << found.tissue, found.needle;
  const Eigen::VectorXd impulse = dense.J.transpose() * multipliers(found);
  const Eigen::VectorXd rest = dense.b - impulse - dense.A * dv;
  const int n = dense.tissue_dofs;
  CHECK(rest.head(n).norm() <= tolerance * std::max(dense.b.head(n).norm(), impulse.head(n).norm()));
  CHECK(rest.tail(rest.size() - n).norm() <= tolerance * (dense.A * dv).tail(rest.size() - n).norm());
  const Eigen::VectorXd velocity = dense.v + dense.J * dv;
  for (std::size_t p = 0; p < found.points.size(); ++p)
    CHECK((found.points[p].velocity - velocity.segment<3>(static_cast<Eigen::Index>(3 * p))).norm() <=
          1e-12 * box.reference_speed);
}

/// Position of the diagonal block of a node at the needle that no support holds.
int free_diagonal(const NeedleInBox& box) {
  for (const int node : box.points[2].tissue.node)
    if (!std::binary_search(box.d->supports.reduced.begin(), box.d->supports.reduced.end(), node))
      return box.d->pattern.diagonal[node];
  throw std::logic_error("all nodes around the point are held");
}

const std::array<std::pair<AxialLaw, LateralLaw>, 7> laws = {{{AxialLaw::bilateral, LateralLaw::bilateral},
                                                              {AxialLaw::none, LateralLaw::bilateral},
                                                              {AxialLaw::bilateral, LateralLaw::none},
                                                              {AxialLaw::unilateral, LateralLaw::bilateral},
                                                              {AxialLaw::unilateral, LateralLaw::coulomb},
                                                              {AxialLaw::friction, LateralLaw::bilateral},
                                                              {AxialLaw::friction, LateralLaw::none}}};

}  // namespace

TEST_CASE("every law agrees with the dense system of its active set, and is kept", "[interaction]") {
  const auto [axial, lateral] = GENERATE(from_range(laws));
  const bool refine = GENERATE(false, true);
  const StepMethod method = GENERATE(StepMethod::plain, StepMethod::kept);
  CAPTURE(static_cast<int>(axial), static_cast<int>(lateral), refine, static_cast<int>(method));
  NeedleInBoxOptions options;
  options.axial = axial;
  options.lateral = lateral;
  options.refine = refine;
  const NeedleInBox box = needle_in_box(options);
  REQUIRE((box.d->hanging.hanging_count() > 0) == refine);
  const Interaction found = solve_tightly(box, method);
  REQUIRE(found.converged);
  const Eigen::VectorXd lambda = multipliers(found);
  REQUIRE(lambda.norm() > 0.0);
  const DenseSolution exact = solve_dense_kkt(box.system(), found);
  REQUIRE(exact.residual < 1e-16);
  // Ten times what the options ask for: the tolerance is on the change of λ, not on its error.
  CHECK(relative_error(lambda, exact.lambda) <= 1e-9);
  check_laws(box, found, 1e-8);
  check_balance(box, found, 1e-9);
  CHECK(found.residual <= 1e-9);
}

TEST_CASE("held directions receive nothing", "[interaction]") {
  NeedleInBoxOptions options;
  options.elements = 2;  // the first point lies on the element of the held base
  const NeedleInBox box = needle_in_box(options);
  REQUIRE(box.points[0].element == 0);
  const Interaction found = solve_tightly(box);
  REQUIRE(found.converged);
  CHECK(relative_error(multipliers(found), solve_dense_kkt(box.system(), found).lambda) <= 1e-9);
  REQUIRE(found.tissue.norm() > 0.0);
  int at_points = 0;
  for (const ContactRows& point : box.points)
    for (const int node : point.tissue.node)
      at_points += std::binary_search(box.d->supports.reduced.begin(), box.d->supports.reduced.end(), node);
  REQUIRE(at_points > 0);  // points do reach supported nodes
  for (std::size_t s = 0; s < box.d->supports.reduced.size(); ++s)
    CHECK((box.d->supports.held[s] * found.tissue.segment<3>(3 * box.d->supports.reduced[s])).norm() <=
          1e-14 * found.tissue.norm());
  CHECK(found.needle.head<6>().isZero(0.0));
}

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

TEST_CASE("the stiffness of the needle over the tissue's does not show in the impulses", "[interaction]") {
  const double ratio = GENERATE(1e8, 1e5, 1e-5, 1e-8);
  const auto [axial, lateral] = GENERATE(std::pair{AxialLaw::bilateral, LateralLaw::bilateral},
                                         std::pair{AxialLaw::friction, LateralLaw::bilateral});
  CAPTURE(ratio, static_cast<int>(axial));
  NeedleInBoxOptions options;
  options.needle_modulus = ratio * options.tissue_modulus;
  options.axial = axial;
  options.lateral = lateral;
  options.points = 4;
  const NeedleInBox box = needle_in_box(options);
  const Interaction found = solve_tightly(box);
  REQUIRE(found.converged);
  CHECK(found.iterations <= 25);
  CHECK(relative_error(multipliers(found), solve_dense_kkt(box.system(), found).lambda) <= 1e-8);
}

TEST_CASE("without points both systems are solved alone", "[interaction]") {
  NeedleInBoxOptions options;
  options.points = 0;
  NeedleInBox box = needle_in_box(options);
  const Interaction found = solve_tightly(box);
  REQUIRE(found.converged);
  CHECK(found.iterations == 1);
  check_balance(box, found, 1e-10);
  REQUIRE(found.tissue.norm() > 0.0);
  REQUIRE(found.needle.norm() > 0.0);
  box.b.setZero();
  box.needle_b.setZero();
  const Interaction still = solve(box);
  CHECK(still.converged);
  CHECK(still.tissue.isZero(0.0));
  CHECK(still.needle.isZero(0.0));
  CHECK(still.residual == 0.0);
}

TEST_CASE("no load and no motion give exactly no force under every law", "[interaction]") {
  const auto [axial, lateral] = GENERATE(from_range(laws));
  const double clamp = GENERATE(0.0, 0.01);
  CAPTURE(static_cast<int>(axial), static_cast<int>(lateral), clamp);
  NeedleInBoxOptions options;
  options.axial = axial;
  options.lateral = lateral;
  NeedleInBox box = needle_in_box(options);
  box.b.setZero();
  box.needle_b.setZero();
  box.needle_velocity.setZero();
  for (ContactRows& point : box.points) {
    point.gap.setZero();
    point.clamp = clamp;
  }
  const Interaction found = solve(box);
  CHECK(found.converged);
  CHECK(multipliers(found).isZero(0.0));
  CHECK(found.tissue.isZero(0.0));
  CHECK(found.needle.isZero(0.0));
  for (const ContactOutcome& outcome : found.points) CHECK(outcome.axial_slip == 0);
  CHECK(found.residual == 0.0);
  CHECK(found.multiplier_change == 0.0);
}

TEST_CASE("an interaction has the same bits twice, and in units that are powers of two of these", "[interaction]") {
  const auto [axial, lateral] = GENERATE(from_range(laws));
  CAPTURE(static_cast<int>(axial), static_cast<int>(lateral));
  NeedleInBoxOptions options;
  options.axial = axial;
  options.lateral = lateral;
  options.refine = true;
  const StepSolverOptions plain{StepMethod::plain, {1e-9, 4000}};
  NeedleInBox box = needle_in_box(options);
  const Interaction first = solve(box, {}, plain), second = solve(box, {}, plain);
  REQUIRE(first.converged);
  CHECK(multipliers(first) == multipliers(second));
  CHECK(first.tissue == second.tissue);
  CHECK(first.needle == second.needle);
  CHECK(multipliers(solve(box)) == multipliers(solve(box)));  // by the kept factor

  // Masses × 2^5, lengths × 2^-7, times × 2^3; the factorization itself takes roots, so the plain method here.
  change_units(32.0, 1.0 / 128.0, 8.0, box);
  const Interaction scaled = solve(box, {}, plain);
  CHECK(multipliers(scaled) == (32.0 / 128.0 / 8.0) * multipliers(first));
  CHECK(scaled.tissue == (1.0 / 128.0 / 8.0) * first.tissue);
  CHECK(scaled.iterations == first.iterations);
  CHECK(scaled.linear_iterations == first.linear_iterations);
  CHECK(scaled.residual == first.residual);
  CHECK(scaled.violation == first.violation);
}

TEST_CASE("what does not converge says so", "[interaction]") {
  NeedleInBoxOptions options;
  const auto [axial, lateral] = GENERATE(from_range(laws));
  options.axial = axial;
  options.lateral = lateral;
  NeedleInBox box = needle_in_box(options);
  InteractionOptions once;
  once.iterations = 1;
  once.patience = GENERATE(0, 12);  // 0: changes of the active set are refused, impulses stay out of the cone till then
  const Interaction found = solve(box, once);
  CHECK_FALSE(found.converged);
  CHECK(found.iterations == 1);
  CHECK(found.tissue.allFinite());
  CHECK(found.needle.allFinite());
  CHECK(multipliers(found).allFinite());
  for (std::size_t p = 0; p < box.points.size(); ++p) {  // inside the cone all the same
    const Eigen::Vector3d& lambda = found.points[p].lambda;
    const double N = lambda.tail<2>().norm() + box.points[p].clamp * box.tau;
    if (axial == AxialLaw::unilateral) CHECK(lambda[0] >= 0.0);
    if (axial == AxialLaw::friction) CHECK((lambda[0] <= 0.5 * N && lambda[0] >= -0.3 * N));
    if (lateral == LateralLaw::coulomb) CHECK(lambda.tail<2>().norm() <= 0.4 * lambda[0] * (1.0 + 1e-14));
  }
}

TEST_CASE("systems that have no solution are not converged, and nothing is NaN", "[interaction]") {
  const auto [axial, lateral] = GENERATE(from_range(laws));
  const StepMethod method = GENERATE(StepMethod::plain, StepMethod::kept);
  const int what = GENERATE(0, 1, 2, 3);
  CAPTURE(static_cast<int>(axial), static_cast<int>(lateral), static_cast<int>(method), what);
  NeedleInBoxOptions options;
  options.axial = axial;
  options.lateral = lateral;
  NeedleInBox box = needle_in_box(options);
  const int some = free_diagonal(box);
  if (what == 0) box.A.block(some) -= 1e3 * box.A.block(some).trace() * Eigen::Matrix3d::Identity();  // indefinite
  if (what == 1) std::fill(box.A.values.begin(), box.A.values.end(), 0.0);                            // singular
  if (what == 2) box.needle_A.diagonal[2].setZero();
  if (what == 2)
    for (auto* blocks : {&box.needle_A.upper}) (*blocks)[1].setZero(), (*blocks)[2].setZero();
  if (what == 3) box.A.values[9 * static_cast<std::size_t>(some)] = NAN;
  const Interaction found = solve(box, {}, {method, {1e-9, 500}});
  CHECK_FALSE(found.converged);
  CHECK(found.tissue.allFinite());
  CHECK(found.needle.allFinite());
  CHECK(multipliers(found).allFinite());
  CHECK(found.points.size() == box.points.size());
  for (const ContactOutcome& outcome : found.points) CHECK(outcome.velocity.allFinite());
  CHECK_FALSE(std::isnan(found.residual));
}

TEST_CASE("rows that depend on one another converge where they agree", "[interaction]") {
  NeedleInBoxOptions options;
  options.points = 3;
  NeedleInBox box = needle_in_box(options);
  const Interaction once = solve_tightly(box);
  box.points.push_back(box.points[1]);  // the same point twice: only the sum of its impulses is determined
  const Interaction twice = solve_tightly(box);
  REQUIRE(once.converged);
  REQUIRE(twice.converged);
  const Eigen::Vector3d sum = twice.points[1].lambda + twice.points[3].lambda;
  CHECK((sum - once.points[1].lambda).norm() <= 1e-8 * once.points[1].lambda.norm());
  CHECK((twice.tissue - once.tissue).norm() <= 1e-8 * once.tissue.norm());
}
