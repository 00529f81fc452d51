#include "verification/studies/use_errors.hpp"

#include "verification/support/catch.hpp"

using namespace finegauge;

TEST_CASE("every mistake in a scene is refused with its file, line and field", "[use_errors]") {
  for (const SceneMistake& mistake : scene_mistakes()) {
    const Refusal refusal = read_with(mistake);
    INFO(mistake.name << ": " << refusal.message);
    CHECK(refusal.refused);
    CHECK(refusal.names_line);
    CHECK(refusal.names_field);
  }
  const Evidence evidence = use_errors_evidence({});
  INFO(to_text(evidence));
  CHECK(evidence.holds());
}
