#include "verification/studies/estimator_ladder.hpp"

#include "verification/support/check_claims.hpp"

using namespace finegauge;

TEST_CASE("on every rung scenes' estimate is within its certified range and the equilibrated one above the error",
          "[ladder]") {
  const Evidence evidence = estimator_ladder_evidence({});
  check_claims(evidence, 60);
}
