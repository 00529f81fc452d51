#include "core/scene/course.hpp"

#include <cmath>
#include <numbers>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

using std::numbers::pi;

struct Derivatives {
  double first, second;
};
/// Central differences; the truncation error is of order h² and the round-off of the second one of order 1e-16 / h².
Derivatives central(const Course& course, double t, double h) {
  const double below = course_factor(course, t - h), here = course_factor(course, t),
               above = course_factor(course, t + h);
  return {(above - below) / (2.0 * h), (above - 2.0 * here + below) / (h * h)};
}

}  // namespace

TEST_CASE("a course is linear between its points, rests outside of them, and repeats by its period",
          "[scene][course]") {
  const LinearCourse once{{{1.0, 2.0}, {2.0, 4.0}, {4.0, 0.0}}, 0.0};
  CHECK(course_factor(once, -5.0) == 2.0);
  CHECK(course_factor(once, 1.0) == 2.0);
  CHECK(course_factor(once, 1.5) == 3.0);
  CHECK(course_factor(once, 2.0) == 4.0);
  CHECK(course_factor(once, 3.5) == 1.0);
  CHECK(course_factor(once, 9.0) == 0.0);
  const LinearCourse again{once.points, 4.0};  // from 1 to 5, with a last second that leads from 0 back to 2
  for (const double shift : {-8.0, -4.0, 0.0, 4.0, 400.0}) {
    CAPTURE(shift);
    CHECK(course_factor(again, 1.5 + shift) == 3.0);
    CHECK(course_factor(again, 3.0 + shift) == 2.0);
    CHECK(course_factor(again, 4.0 + shift) == 0.0);
    CHECK(course_factor(again, 4.5 + shift) == 1.0);
    CHECK(course_factor(again, 4.75 + shift) == 1.5);
  }
  CHECK(course_factor(LinearCourse{{{3.0, 7.0}}, 0.0}, 100.0) == 7.0);
  CHECK(course_factor(LinearCourse{{{3.0, 7.0}}, 2.0}, 100.0) == 7.0);
}

TEST_CASE("breathing starts at exhale, is at inhale half a period later, and repeats", "[scene][course]") {
  const double T = GENERATE(4.0, 0x1p-10);
  const BreathingCourse sine{BreathingWaveform::sine, T, 0.0}, cos4{BreathingWaveform::cos4, T, 0.0};
  for (const Course& course : {Course(sine), Course(cos4)}) {
    CHECK(course_factor(course, -0.3 * T) == 0.0);
    CHECK(course_factor(course, 0.0) == 0.0);
    CHECK(course_factor(course, 0.5 * T) == 1.0);
    CHECK(course_factor(course, T) == 0.0);
    for (int k = 1; k < 100; ++k) {
      const double t = T * k / 100.0;
      CHECK_THAT(course_factor(course, t + 3.0 * T), WithinAbs(course_factor(course, t), 1e-14));
      CHECK_THAT(course_factor(course, T - t), WithinAbs(course_factor(course, t), 1e-14));
      CHECK((course_factor(course, t) > 0.0 && course_factor(course, t) <= 1.0));
    }
  }
  for (int k = 0; k <= 100; ++k) {
    const double t = T * k / 100.0;
    CHECK_THAT(course_factor(sine, t), WithinAbs(0.5 - 0.5 * std::cos(2.0 * pi * t / T), 1e-14));
    CHECK_THAT(course_factor(cos4, t), WithinAbs(std::pow(std::cos(pi * t / T - 0.5 * pi), 4), 1e-14));
  }
}

TEST_CASE("cos4 breathing rests at exhale for more than half of its time, the sine for exactly half",
          "[scene][course]") {
  // Time below half the amplitude: sin⁴ < 1/2 where |sin| < 2^(-1/4), a share of 2 asin(2^(-1/4)) / π of the period.
  const auto share_below_half = [](BreathingWaveform waveform) {
    const BreathingCourse course{waveform, 1.0, 0.0};
    int below = 0;
    const int samples = 100000;
    for (int k = 0; k < samples; ++k) below += course_factor(course, (k + 0.5) / samples) < 0.5;
    return double(below) / samples;
  };
  CHECK_THAT(share_below_half(BreathingWaveform::sine), WithinAbs(0.5, 2e-5));
  CHECK_THAT(share_below_half(BreathingWaveform::cos4), WithinAbs(2.0 * std::asin(std::pow(2.0, -0.25)) / pi, 2e-5));
  CHECK(2.0 * std::asin(std::pow(2.0, -0.25)) / pi > 0.6);
}

TEST_CASE("with a ramp breathing starts and goes on without a jump of velocity or acceleration", "[scene][course]") {
  const BreathingWaveform waveform = GENERATE(BreathingWaveform::sine, BreathingWaveform::cos4);
  const double ramp = GENERATE(1.7, 4.0, 10.0);
  const BreathingCourse course{waveform, 4.0, ramp};
  CAPTURE(int(waveform), ramp);
  // The factor starts as (π t/T)² 10 (t/ramp)³ at least, at most 1.3 t⁵ here: central differences of half that over h
  // and of that over h².
  CHECK(course_factor(course, 0.0) == 0.0);
  for (const double h : {1e-1, 1e-2}) {
    const Derivatives start = central(course, 0.0, h);
    CHECK(std::abs(start.first) <= 0.7 * std::pow(h, 4));
    CHECK(std::abs(start.second) <= 1.4 * std::pow(h, 3));
    CHECK(start.first > 0.0);  // it does start
  }
  // From one side and from the other: first and second derivatives differ by no more than their own change over h.
  for (const double t : {ramp, 2.0, 4.0, 8.0}) {
    CAPTURE(t);
    const double h = 1e-4;
    const Derivatives before = central(course, t - h, h), after = central(course, t + h, h);
    CHECK(std::abs(after.first - before.first) <= 2.0 * h * 25.0);            // |f''| <= 25 / s²
    CHECK(std::abs(after.second - before.second) <= 2.0 * h * 100.0 + 1e-7);  // |f'''| <= 100 / s³, round-off
  }
  // After the ramp it is the waveform itself.
  const BreathingCourse bare{waveform, 4.0, 0.0};
  CHECK(course_factor(course, ramp) == course_factor(bare, ramp));
  CHECK(course_factor(course, ramp + 0.3) == course_factor(bare, ramp + 0.3));
  CHECK(course_factor(course, 0.5 * ramp) == 0.5 * course_factor(bare, 0.5 * ramp));
}

TEST_CASE("without a ramp the sine starts with the acceleration that its period says, cos4 with none",
          "[scene][course]") {
  const double T = 4.0, h = 1e-3;
  const auto one_sided = [&](const Course& course) {  // f(0) = f'(0) = 0: f(h) = f'' h²/2
    return 2.0 * course_factor(course, h) / (h * h);
  };
  CHECK_THAT(one_sided(BreathingCourse{BreathingWaveform::sine, T, 0.0}), WithinRel(2.0 * pi * pi / (T * T), 1e-5));
  CHECK(one_sided(BreathingCourse{BreathingWaveform::cos4, T, 0.0}) < 1e-5);
}
