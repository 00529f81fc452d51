#include "verification/studies/atlas.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <limits>
#include <stdexcept>

#include "core/scene/scene_error.hpp"
#include "verification/studies/atlas_scene.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// Sound and answered from 1e-3 to 1e3; every other end that a value can have is somewhere outside.
AtlasPoint fake(double value) {
  if (value == 1e-12) return {.value = value, .ok = true, .measure = std::numeric_limits<double>::quiet_NaN()};
  if (value == 1e-6) throw std::runtime_error("out of memory");
  if (value == 1e-4) throw SceneError("scene.toml:3: found 1e-4");
  if (value == 1e4) return refusal(value, "did not converge");
  if (value == 1e5) throw std::invalid_argument("found 1e5");
  announce_scene("value = " + std::to_string(value), {});
  if (value == 1e6) {
    std::signal(SIGSEGV, SIG_DFL);  // sanitizers would report it
    std::raise(SIGSEGV);
  }
  if (value == 1e8)
    for (;;) ::pause();
  if (value == 1e10) ::_exit(3);
  AtlasChecks checks;
  checks.add("size", std::abs(std::log10(value)), 3.5);
  AtlasPoint point = checks.point(value);
  point.scene = "text";
  point.files = {{"file", std::string("a\0b", 3)}};
  return point;
}

AtlasAxis fake_axis() {
  AtlasAxis axis;
  axis.group = "fake";
  axis.name = "fake";
  axis.normal = 1.0;
  axis.values = {1e-12, 1e-6, 1e-5, 1e-4, 1e-3, 1.0, 1e3, 1e4, 1e5, 1e6, 1e8, 1e10};
  axis.more_values = {10.0, 100.0};
  axis.at = fake;
  axis.safe = {1e-4, 1e5};
  axis.answered = {1e-3, 1e3};
  return axis;
}

AtlasSweep fake_sweep(AtlasOptions options = {}) {
  options.seconds = 0.05;  // of processor time; twenty times as much by the clock
  return sweep(fake_axis(), options);
}

const AtlasPoint& at(const AtlasSweep& found, double value) {
  const auto point = std::ranges::find(found.points, value, &AtlasPoint::value);
  REQUIRE(point != found.points.end());
  return *point;
}

void check_axes(const std::string& group) {
  int axes = 0;
  for (const AtlasAxis& axis : atlas_axes()) {
    if (axis.group != group) continue;
    ++axes;
    const AtlasSweep found = sweep(axis);
    INFO(to_text(atlas_table(axis, found)));
    CHECK(covers(found.safe, axis.safe));
    CHECK(covers(found.answered, axis.answered));
    // A scene that is saved is one that can be read, unless being refused is what it shows.
    for (const AtlasPoint& point : found.first_failing)
      if (!point.scene.empty()) CHECK_NOTHROW(scene_from_text(point.scene, point.files));
  }
  CHECK(axes > 3);
}

}  // namespace

TEST_CASE("the sound range of materials and units does not shrink", "[atlas]") { check_axes("material"); }
TEST_CASE("the sound range of meshes does not shrink", "[atlas]") { check_axes("mesh"); }
TEST_CASE("the sound range of rotations and crushed cells does not shrink", "[atlas]") { check_axes("kinematics"); }
TEST_CASE("the sound range of steps, densities and decay does not shrink", "[atlas]") { check_axes("dynamics"); }
TEST_CASE("the sound range of needles in tissue does not shrink", "[atlas]") { check_axes("contact"); }

TEST_CASE("every axis of the atlas says what it varies, against what, and why its limits are what they are",
          "[atlas]") {
  for (const AtlasAxis& axis : atlas_axes()) {
    CAPTURE(axis.name);
    CHECK_FALSE(axis.about.empty());
    CHECK_FALSE(axis.truth.empty());
    CHECK_FALSE(axis.reason.empty());
    CHECK(std::ranges::is_sorted(axis.values));
    CHECK(axis.values.front() >= 0.0);
    for (const double value : {axis.normal, axis.safe.low, axis.safe.high, axis.answered.low, axis.answered.high})
      CHECK(std::ranges::find(axis.values, value) != axis.values.end());
    CHECK(axis.safe.low <= axis.answered.low);
    CHECK(axis.safe.high >= axis.answered.high);
    CHECK(std::ranges::count(atlas_axes(), axis.name, &AtlasAxis::name) == 1);
  }
}

TEST_CASE("the atlas finds the range around the usual value, and the failures that end it", "[atlas]") {
  const AtlasSweep found = fake_sweep();
  INFO(to_text(atlas_table(fake_axis(), found)));
  REQUIRE(found.points.size() == fake_axis().values.size());
  REQUIRE(found.safe);
  CHECK(found.safe->low == 1e-4);
  CHECK(found.safe->high == 1e5);
  REQUIRE(found.answered);
  CHECK(found.answered->low == 1e-3);
  CHECK(found.answered->high == 1e3);
  REQUIRE(found.first_failing.size() == 2);
  CHECK(found.first_failing[0].value == 1e-5);
  CHECK(found.first_failing[1].value == 1e6);
  CHECK(covers(found.safe, {1e-4, 1e5}));
  CHECK_FALSE(covers(found.safe, {1e-5, 1e5}));
  CHECK_FALSE(covers(found.answered, {1e-3, 1e4}));
  CHECK_FALSE(covers(std::nullopt, {1.0, 1.0}));
}

TEST_CASE("a crash, a value that does not end and a number that is none are failures of one point", "[atlas]") {
  const AtlasSweep found = fake_sweep();
  CHECK(at(found, 1e-12).why == " (an answer without a number)");
  CHECK_FALSE(at(found, 1e-12).ok);
  CHECK_FALSE(at(found, 1e-6).ok);
  CHECK(at(found, 1e-4).refused);
  CHECK(at(found, 1e5).refused);
  CHECK(at(found, 1e6).why.rfind("a crash: ", 0) == 0);
  CHECK(at(found, 1e6).scene == "value = 1000000.000000");  // what it said before it died
  CHECK(at(found, 1e8).why == "no end within 1 s");
  CHECK(at(found, 1e10).why == "the process ended by itself, code 3");
  // What answers comes back whole.
  const AtlasPoint& usual = at(found, 1.0);
  CHECK(usual.answered());
  CHECK(usual.why == "size 0, at most 3.5");
  CHECK(usual.scene == "text");
  REQUIRE(usual.files.size() == 1);
  CHECK(usual.files[0].content == std::string("a\0b", 3));
}

TEST_CASE("a sweep that is interrupted keeps what it has, and no range reaches past a value that was not tried",
          "[atlas]") {
  int tried = 0;
  AtlasOptions options;
  options.progress = [&](double, const std::string&) { ++tried; };
  options.interrupted = [&] { return tried == 3; };
  CHECK(fake_sweep(options).points.size() == 2);  // the third was stopped
  CHECK(atlas_values(fake_axis(), true).size() == fake_axis().values.size() + 2);

  AtlasPoint low, high;
  low.value = 0.1, low.ok = true;
  high.value = 10.0;
  const AtlasSweep parts = judge(fake_axis(), {high, low});
  REQUIRE(parts.safe);
  CHECK(parts.safe->low == 0.1);
  CHECK(parts.safe->high == 0.1);
  high.value = 1.0;  // the usual value itself
  CHECK_FALSE(judge(fake_axis(), {high, low}).safe);
}

TEST_CASE("a scene's numbers keep all their digits, and a missing one is no scene", "[atlas]") {
  CHECK(filled("a = $A, b = $B", {{"A", 0.1}, {"B", 1e-300}}) == "a = 0.10000000000000001, b = 1e-300");
  CHECK_THROWS_AS(filled("a = $A", {}), std::logic_error);
}
