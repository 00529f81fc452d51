#pragma once

#include <cmath>

namespace finegauge {

// Numbers from outside are zero or of a magnitude within these: then volumes, moments of sections and energies,
// products of four or five of them, are neither infinite nor lost. No unit of length, time or force needs others.
constexpr double least_magnitude = 1e-60, most_magnitude = 1e60;

/// False for NaN.
inline bool has_sound_magnitude(double x) {
  return x == 0.0 || (std::abs(x) >= least_magnitude && std::abs(x) <= most_magnitude);
}

}  // namespace finegauge
