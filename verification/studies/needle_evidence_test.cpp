#include "verification/studies/needle_evidence.hpp"

#include "verification/support/check_claims.hpp"

using namespace finegauge;

TEST_CASE("a needle bends, buckles, turns and pushes as its closed forms say", "[evidence][needle]") {
  const Evidence evidence = needle_evidence({});
  REQUIRE_FALSE(evidence.tables.empty());
  check_claims(evidence, 61);
}

TEST_CASE("closed forms of buckling with shear and compression agree among themselves", "[evidence][needle]") {
  for (const NeedleTip tip : {NeedleTip::free, NeedleTip::fixed}) {
    // A chain of ever shorter elements is a needle: order 2 to round-off of 1 - cos(x / n).
    const double exact = exact_buckling_load(tip), x = tip == NeedleTip::free ? 1.5707963 : 6.2831853;
    CHECK_THAT((exact_buckling_load_of_chain(tip, 1000) / exact - 1.0) * 12e6 / (x * x), WithinAbs(1.0, 0.05));
    // For little load both are c EI / L² less the same first correction.
    CHECK_THAT(haringx_buckling_load(tip) / exact, WithinAbs(1.0, 1e-3));
  }
  CHECK(exact_buckling_load(NeedleTip::free) < exact_buckling_load(NeedleTip::pinned));
  CHECK(exact_buckling_load(NeedleTip::pinned) < exact_buckling_load(NeedleTip::fixed));
}
