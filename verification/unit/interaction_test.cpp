#include "core/needle/interaction.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "verification/support/interaction_laws.hpp"

using namespace finegauge;

namespace {

/// Position of the diagonal block of a node at the needle that no support holds.
int free_diagonal(const NeedleInBox& box) {
  for (const int node : box.points[2].tissue.node)
    if (!std::binary_search(box.d->supports.reduced.begin(), box.d->supports.reduced.end(), node))
      return box.d->pattern.diagonal[node];
  throw std::logic_error("all nodes around the point are held");
}

}  // namespace

TEST_CASE("every law agrees with the dense system of its active set, and is kept", "[interaction]") {
  const auto [axial, lateral] = GENERATE(from_range(contact_laws));
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
  const auto [axial, lateral] = GENERATE(from_range(contact_laws));
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
  const auto [axial, lateral] = GENERATE(from_range(contact_laws));
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
  const auto [axial, lateral] = GENERATE(from_range(contact_laws));
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

TEST_CASE("contact forces are not converged before the tissue under them is solved", "[interaction]") {
  // A tolerance on forces that the second iteration meets, and a solver that is cut off early: what is left of the
  // tissue's equations decides.
  const NeedleInBox box = needle_in_box({});
  InteractionOptions loose;
  loose.tolerance = 0.1;
  const DenseInteraction dense = dense_interaction(box.system());
  int solved = 0, cut_off = 0;
  for (int limit = 1; limit <= 200; limit += 3) {
    const Interaction found = solve(box, loose, {StepMethod::plain, {1e-9, limit}});
    const int n = dense.tissue_dofs;
    const Eigen::VectorXd impulse = (dense.J.transpose() * multipliers(found)).head(n);
    const Eigen::VectorXd rest = dense.b.head(n) - impulse - dense.A.topLeftCorner(n, n) * found.tissue;
    const double left = rest.norm() / std::max(dense.b.head(n).norm(), impulse.norm());
    CAPTURE(limit, left, found.iterations);
    if (found.converged) CHECK(left <= 1e-7);
    ++(found.converged ? solved : cut_off);
  }
  CHECK(solved > 0);
  CHECK(cut_off > 0);
}

TEST_CASE("systems that have no solution are not converged, and nothing is NaN", "[interaction]") {
  const auto [axial, lateral] = GENERATE(from_range(contact_laws));
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
