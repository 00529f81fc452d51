#include "verification/studies/friction_evidence.hpp"

#include "verification/support/check_claims.hpp"

using namespace finegauge;

TEST_CASE("friction holds and slides, cuts come and go, and nothing acts outside", "[evidence][friction]") {
  const Evidence evidence = friction_evidence({});
  REQUIRE_FALSE(evidence.tables.empty());
  check_claims(evidence, 36);
}
