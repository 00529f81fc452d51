#pragma once

#include <array>
#include <variant>
#include <vector>

namespace finegauge {

/// A factor over time: linear between its points, constant before the first and after the last. With a period it
/// repeats from its first point on, linear from the last point to the first one of the next period.
struct LinearCourse {
  std::vector<std::array<double, 2>> points;  ///< time [s], strictly ascending, and factor; at least one
  double period = 0.0;                        ///< [s], not below the time from the first to the last point; 0: once
};

enum class BreathingWaveform {
  sine,  ///< sin²(π t/T), as long in as out
  cos4   ///< cos⁴(π t/T - π/2), which rests at exhale longer than at inhale (Lujan et al. 1999, their n = 2)
};
/// Breathing as a factor over time: 0 at exhale, 1 at inhale, starting from exhale at t = 0; zero before. Over the ramp
/// it is multiplied by 10 s³ - 15 s⁴ + 6 s⁵, s = t/ramp, which has no slope and no curvature at either end: with a ramp
/// factor, velocity and acceleration start from zero and have no jump. Without one the sine starts with an acceleration
/// of 2 π²/T².
struct BreathingCourse {
  BreathingWaveform waveform = BreathingWaveform::sine;
  double period = 1.0;  ///< T [s], > 0
  double ramp = 0.0;    ///< [s]; 0: none
};

using Course = std::variant<LinearCourse, BreathingCourse>;

double course_factor(const Course& course, double time);

}  // namespace finegauge
