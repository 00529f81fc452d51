#include "verification/studies/solver_evidence.hpp"

#include "verification/support/catch.hpp"

using namespace finegauge;

TEST_CASE("what the solvers leave over is what theory allows, and backward Euler keeps its closed forms",
          "[evidence][solver]") {
  const Evidence evidence = solver_evidence({});
  INFO(to_text(evidence));
  REQUIRE(evidence.claims.size() > 30);
  REQUIRE_FALSE(evidence.tables.empty());
  for (const Claim& claim : evidence.claims) {
    CAPTURE(claim.name, claim.value, claim.low, claim.high, claim.reason);
    CHECK(claim.holds());
  }
}
