#include "verification/studies/friction_evidence.hpp"

#include "verification/support/catch.hpp"

using namespace finegauge;

TEST_CASE("friction holds and slides, cuts come and go, and nothing acts outside", "[evidence][friction]") {
  const Evidence evidence = friction_evidence({});
  INFO(to_text(evidence));
  REQUIRE(evidence.claims.size() > 35);
  REQUIRE_FALSE(evidence.tables.empty());
  for (const Claim& claim : evidence.claims) {
    CAPTURE(claim.name, claim.value, claim.low, claim.high, claim.reason);
    CHECK(claim.holds());
  }
}
