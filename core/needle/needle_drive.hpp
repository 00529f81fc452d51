#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/needle/needle.hpp"

namespace finegauge {

/// A straight motion of the base at constant speed; zero displacement: a dwell.
struct Stroke {
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< [m]
  double duration = 0.0;                                   ///< [s], > 0
};

/// How the needle is held and moved: node 0 follows the strokes one after the other and then rests.
struct NeedleDrive {
  std::vector<Stroke> strokes;
  bool base_turns = false;  ///< node 0 may rotate; else its rotation stays the identity
  bool guided = true;       ///< nodes outside the tissue are held across the base axis, on the line through the base: a
                            ///< sheath; without it slender needles buckle at less than most puncture forces
};
Eigen::Vector3d base_displacement(const NeedleDrive& drive, double time);
double total_duration(const NeedleDrive& drive);  ///< [s]
double fastest_speed(const NeedleDrive& drive);   ///< [m/s]

/// Euler's buckling load of the whole straight needle [N], clamped at its base and free at its tip.
double buckling_load_fixed_free(const Needle& needle);

}  // namespace finegauge
