#include "core/needle/needle_drive.hpp"

#include <algorithm>
#include <numbers>

namespace finegauge {

Eigen::Vector3d base_displacement(const NeedleDrive& drive, double time) {
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  for (const Stroke& stroke : drive.strokes) {
    if (time < stroke.duration) return displacement + (time / stroke.duration) * stroke.displacement;
    displacement += stroke.displacement;
    time -= stroke.duration;
  }
  return displacement;
}

double total_duration(const NeedleDrive& drive) {
  double duration = 0.0;
  for (const Stroke& stroke : drive.strokes) duration += stroke.duration;
  return duration;
}

double fastest_speed(const NeedleDrive& drive) {
  double fastest = 0.0;
  for (const Stroke& stroke : drive.strokes) fastest = std::max(fastest, stroke.displacement.norm() / stroke.duration);
  return fastest;
}

double buckling_load_fixed_free(const Needle& needle) {
  double length = 0.0, weakest = needle.sections.front().EI_2;
  for (int e = 0; e < needle.element_count(); ++e) {
    length += (needle.rest_positions.col(e + 1) - needle.rest_positions.col(e)).norm();
    weakest = std::min({weakest, needle.sections[e].EI_2, needle.sections[e].EI_3});
  }
  const double half_wave = 2.0 * length;
  return std::numbers::pi * std::numbers::pi * weakest / (half_wave * half_wave);
}

}  // namespace finegauge
