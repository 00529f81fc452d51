// Notes of benchmarks/program/motion_run.hpp on scenes with a needle.

#include <string>

#include "benchmarks/program/motion_run.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

namespace {

const std::string scene_text = R"([box]
size = [0.04, 0.02, 0.02]
cells = [2, 1, 1]
[material]
youngs_modulus = 1e4
poisson_ratio = 0.3
[[support]]
surface = "x_max"
displacement = [0, 0, 0]
[dynamics]
time_step = 0.01
density = 1000
[needle]
youngs_modulus = 1e9
poisson_ratio = 0.3
radius = 0.001
density = 2000
base = [-0.05, 0.01, 0.01]
tip = [-0.01, 0.01, 0.01]
[[stroke]]
displacement = [0.005, 0, 0]
speed = 0.01
[[stroke]]
displacement = [-0.005, 0, 0]
speed = 0.01
[contact]
puncture_strength = 3
cut_advance = 0.002
friction = 0.5
)";

/// How many notes of a run, stopped after its first frame, have these words.
int notes_with(const std::string& words, const std::vector<std::string>& overrides) {
  const TemporaryFile file("motion_notes.toml", scene_text);
  const MotionRun run = run_motion(read_scene(file.path(), overrides), [](const auto&) { return false; });
  REQUIRE_FALSE(run.failed);
  REQUIRE(run.frames.size() == 1);
  int found = 0;
  for (const std::string& note : run.notes) found += note.find(words) != std::string::npos;
  return found;
}

int notes_on_speed(const std::vector<std::string>& overrides) {
  return notes_with("more than a quarter of cut_advance", overrides);
}

}  // namespace

TEST_CASE("an insertion by more than a quarter of d_c a frame is noted", "[notes]") {
  // 0.5 mm of 2 mm in 10 ms: 50 mm/s.
  CHECK(notes_on_speed({}) == 0);
  CHECK(notes_on_speed({"stroke[0].speed=0.0499"}) == 0);
  CHECK(notes_on_speed({"stroke[0].speed=0.0501"}) == 1);
  CHECK(notes_on_speed({"stroke[1].speed=0.0501"}) == 1);  // the fastest stroke counts, out or in
  CHECK(notes_on_speed({"stroke[0].speed=0.0501", "dynamics.time_step=0.009"}) == 0);
  CHECK(notes_on_speed({"stroke[0].speed=0.0499", "contact.cut_advance=0.0019"}) == 1);
}

TEST_CASE("a needle of elements longer than a cut is noted", "[notes]") {
  const std::string words = "elements are longer than cut_advance";  // 40 mm of needle, cuts of 2 mm
  CHECK(notes_with(words, {"needle.elements=19"}) == 1);
  CHECK(notes_with(words, {"needle.elements=20"}) == 0);
  CHECK(notes_with(words, {"needle.elements=20", "contact.cut_advance=0.0019"}) == 1);
}
