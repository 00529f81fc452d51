#include "core/mesh/tetrahedron_children.hpp"

#include <Eigen/LU>
#include <cmath>

namespace finegauge {

std::array<std::array<int, 4>, 4> tetrahedron_child_map(int child) {
  // In absolute units a parent's coordinates are M times a child's: a midpoint's weight counts for both of its ends.
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  for (int c = 0; c < 4; ++c)
    for (const int end : tetrahedron_children[child][c]) M(end, c) += 1.0;
  const Eigen::Matrix4d twice_inverse = 2.0 * M.inverse();
  std::array<std::array<int, 4>, 4> map{};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) map[i][j] = static_cast<int>(std::lround(twice_inverse(i, j)));
  return map;
}

}  // namespace finegauge
