#include "core/scene/course.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace finegauge {
namespace {

double factor(const LinearCourse& course, double time) {
  const auto& points = course.points;
  const double start = points.front()[0];
  if (course.period > 0.0) {
    time = std::fmod(time - start, course.period);
    time = start + (time < 0.0 ? time + course.period : time);
  }
  const auto after = std::ranges::find_if(points, [&](const auto& point) { return point[0] > time; });
  if (after == points.begin()) return points.front()[1];
  std::array<double, 2> a = after[-1], b = a;
  if (after != points.end())
    b = *after;
  else if (course.period > 0.0)
    b = {start + course.period, points.front()[1]};
  return b[0] > a[0] ? a[1] + (b[1] - a[1]) * ((time - a[0]) / (b[0] - a[0])) : a[1];
}

double factor(const BreathingCourse& course, double time) {
  if (time <= 0.0) return 0.0;
  const double sine = std::sin(std::numbers::pi * std::fmod(time / course.period, 1.0));
  const double squared = sine * sine;
  const double breath = course.waveform == BreathingWaveform::sine ? squared : squared * squared;
  if (!(time < course.ramp)) return breath;
  const double s = time / course.ramp;
  return breath * (s * s * s * (10.0 + s * (6.0 * s - 15.0)));
}

}  // namespace

double course_factor(const Course& course, double time) {
  return std::visit([&](const auto& of_a_kind) { return factor(of_a_kind, time); }, course);
}

}  // namespace finegauge
