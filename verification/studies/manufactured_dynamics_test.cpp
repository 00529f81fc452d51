#include "verification/studies/manufactured_dynamics.hpp"

#include <cmath>
#include <set>

#include "verification/support/check_claims.hpp"

using namespace finegauge;

TEST_CASE("a manufactured motion has order 1 in time with the constant of theory, and order 2 in space",
          "[manufactured][dynamics]") {
  const Evidence evidence = manufactured_dynamics_evidence({});
  check_claims(evidence, 30);
  std::set<std::string> names;
  for (const Claim& claim : evidence.claims) names.insert(claim.name);
  for (const MovingCase& the_case : moving_cases()) CHECK(names.count(the_case.name + "_displacement_order") == 1);
}

TEST_CASE("the manufactured motions move, all around and inside", "[manufactured][dynamics]") {
  for (const MovingCase& the_case : moving_cases()) {
    INFO(the_case.name);
    // The boundary turns back on its way, and inertia is no trifle beside elasticity.
    const TimeCourse& g = the_case.course;
    CHECK(g(0.0) * g(the_case.duration) < 0.0);
    const Material& material = the_case.material;
    const double wave = std::sqrt((material.lambda() + 2.0 * material.mu()) / the_case.density);
    CHECK(std::abs(g.rate) / wave > 1.0);
    const SpaceRow row = space_row(the_case, 4, 32);
    CHECK((row.hanging_nodes > 0) == !the_case.mesh.levels.empty());
  }
  // The factors of time are each other's derivatives.
  const TimeCourse g = MovingCase{}.course;
  for (int k = 0; k < 3; ++k) CHECK_THAT((g(0.4 + 1e-4, k) - g(0.4 - 1e-4, k)) / 2e-4, WithinAbs(g(0.4, k + 1), 1e-6));
  // Cells represent the trilinear field, and no coarser polynomial does.
  MovingCase the_case;
  the_case.field = trilinear_solution();
  const Discretization d = discretize(refined_cube({}, 4), the_case.material, {});
  const FormulaErrors errors = formula_errors(d, the_case.field.formula, interpolant(d, the_case.field.formula));
  CHECK(errors.displacement < 1e-14 * errors.displacement_norm);
  const Jets at = the_case.field.formula(coordinates_at({0.3, 0.6, 0.2}));
  for (int i = 0; i < 3; ++i) CHECK(at[i].hessian.norm() > 0.01);
}

TEST_CASE("damping changes the constant of backward Euler's error", "[manufactured][dynamics]") {
  // Otherwise the damped motion would say nothing that the undamped one does not.
  MovingCase the_case;
  the_case.field = trilinear_solution();
  const double undamped = first_order_error(the_case, 4);
  the_case.mass_damping = 0.8;
  the_case.stiffness_damping = 0.05;
  CHECK(std::abs(first_order_error(the_case, 4) / undamped - 1.0) > 0.05);
}
