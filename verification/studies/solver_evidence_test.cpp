#include "verification/studies/solver_evidence.hpp"

#include "verification/support/check_claims.hpp"

using namespace finegauge;

TEST_CASE("what the solvers leave over is what theory allows, and backward Euler keeps its closed forms",
          "[evidence][solver]") {
  const Evidence evidence = solver_evidence({});
  REQUIRE_FALSE(evidence.tables.empty());
  check_claims(evidence, 31);
}
