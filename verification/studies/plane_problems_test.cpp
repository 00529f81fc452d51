#include "verification/studies/plane_problems.hpp"

#include "verification/support/catch.hpp"

using namespace finegauge;

TEST_CASE("Cook's membrane, NAFEMS LE1 and Kirsch's hole come to their known displacements and stresses",
          "[classic_problems]") {
  const Evidence evidence = plane_problems_evidence({});
  INFO(to_text(evidence));
  REQUIRE(evidence.claims.size() > 20);
  for (const Claim& claim : evidence.claims) {
    CAPTURE(claim.name);
    CHECK(claim.holds());
  }
}
