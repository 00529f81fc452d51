#include "verification/studies/estimator_ladder.hpp"

#include "verification/support/catch.hpp"

using namespace finegauge;

TEST_CASE("on every rung scenes' estimate is within its certified range and the equilibrated one above the error",
          "[ladder]") {
  const Evidence evidence = estimator_ladder_evidence({});
  INFO(to_text(evidence));
  CHECK(evidence.claims.size() > 30);
  for (const Claim& claim : evidence.claims) {
    CAPTURE(claim.name, claim.value, claim.low, claim.high);
    CHECK(claim.holds());
  }
}
