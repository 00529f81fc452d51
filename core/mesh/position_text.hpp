#pragma once

#include <Eigen/Core>
#include <array>
#include <sstream>
#include <string>

namespace finegauge {

/// What messages about meshes call axes and places.

inline constexpr std::array<const char*, 3> axis_names = {"x", "y", "z"};

/// "(0.1, 0, -2.5)", six digits.
inline std::string describe(const Eigen::Vector3d& position) {
  std::ostringstream text;
  text.precision(6);
  text << "(" << position.x() << ", " << position.y() << ", " << position.z() << ")";
  return text.str();
}

}  // namespace finegauge
