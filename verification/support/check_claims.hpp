#pragma once

#include <set>
#include <string>

#include "verification/support/catch.hpp"
#include "verification/support/evidence.hpp"

namespace finegauge {

/// What every study's test asks: enough claims, under names of their own, and each of them holds.
inline void check_claims(const Evidence& evidence, std::size_t at_least) {
  INFO(to_text(evidence));
  REQUIRE(evidence.claims.size() >= at_least);
  std::set<std::string> names;
  for (const Claim& claim : evidence.claims) {
    INFO(to_text({claim}));
    CHECK(claim.holds());
    CHECK(names.insert(claim.name).second);
  }
}

}  // namespace finegauge
