#include "verification/support/evidence.hpp"

#include <limits>

#include "verification/support/catch.hpp"

using namespace finegauge;

TEST_CASE("a claim holds within its bounds, both included, and never as no number", "[evidence]") {
  Claim claim{"order", 1.0, 1.0, 2.0, "theory"};
  CHECK(claim.holds());
  claim.value = 2.0;
  CHECK(claim.holds());
  for (const double value : {0.999, 2.001, std::numeric_limits<double>::quiet_NaN()}) {
    claim.value = value;
    CHECK_FALSE(claim.holds());
  }
}

TEST_CASE("evidence without claims holds nothing, and one claim that fails is enough", "[evidence]") {
  Evidence evidence;
  CHECK_FALSE(evidence.holds());
  evidence.claim("a", 1.0, 0.0, 2.0, "why");
  CHECK(evidence.holds());
  evidence.claim("b", 3.0, 0.0, 2.0, "why");
  CHECK_FALSE(evidence.holds());
  const std::string text = to_text(evidence);
  CHECK_THAT(text, ContainsSubstring("holds  a  1  in [0, 2]  why"));
  CHECK_THAT(text, ContainsSubstring("FAILS  b  3  in [0, 2]  why"));
}

TEST_CASE("a table is aligned, names to the left and numbers to the right", "[evidence]") {
  EvidenceTable table{"Title", {"mesh", "error"}, {{std::string("n = 4"), 0.25}, {std::string("n = 16"), 1.5e-10}}};
  CHECK(to_text(table) == "Title\n  mesh      error\n  n = 4      0.25\n  n = 16  1.5e-10\n");
  table.rows.push_back({1.0});
  CHECK_THROWS_AS(to_text(table), std::invalid_argument);
}
