#include "verification/studies/plane_problems.hpp"

#include "verification/support/check_claims.hpp"

using namespace finegauge;

TEST_CASE("Cook's membrane, NAFEMS LE1 and Kirsch's hole come to their known displacements and stresses",
          "[classic_problems]") {
  const Evidence evidence = plane_problems_evidence({});
  check_claims(evidence, 21);
}
