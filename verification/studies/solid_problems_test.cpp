#include "verification/studies/solid_problems.hpp"

#include "verification/support/check_claims.hpp"

using namespace finegauge;

TEST_CASE("thick walls, the thick plate and the half-space come to their closed forms, near incompressibility too",
          "[classic_problems]") {
  const Evidence evidence = solid_problems_evidence({});
  check_claims(evidence, 41);
}

TEST_CASE("the closed forms have the published digits", "[classic_problems]") {
  // MacNeal & Harder's cylinder; the sphere and Boussinesq by hand.
  const auto exact = [](Wall wall, double nu) { return solve_thick_wall(wall, nu, Dilatation::mean, 4); };
  CHECK_THAT(exact(Wall::cylinder, 0.49).exact_displacement, WithinAbs(5.0399e-3, 5e-8));
  CHECK_THAT(exact(Wall::cylinder, 0.499).exact_displacement, WithinAbs(5.0602e-3, 5e-8));
  CHECK_THAT(exact(Wall::cylinder, 0.4999).exact_displacement, WithinAbs(5.0623e-3, 5e-8));
  CHECK_THAT(exact(Wall::cylinder, 0.3).exact_hoop_stress, WithinRel(1.25, 1e-14));
  CHECK_THAT(exact(Wall::sphere, 0.3).exact_displacement, WithinRel(8e-4, 1e-14));
  CHECK_THAT(exact(Wall::sphere, 0.4999).exact_displacement, WithinAbs(8.571143e-4, 5e-11));
  CHECK_THAT(exact(Wall::sphere, 0.3).exact_hoop_stress, WithinAbs(0.7142857, 5e-8));
  CHECK_THAT(half_space_settlement(), WithinAbs(2.6738e-4, 5e-9));
}
