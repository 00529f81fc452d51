#include "core/needle/contact_rows.hpp"

#include <Eigen/Geometry>

namespace finegauge {

Eigen::Matrix3d frame_along(const Eigen::Vector3d& n, const Eigen::Vector3d& like) {
  Eigen::Vector3d t = like - n * n.dot(like);
  if (!(t.squaredNorm() > 1e-6 * like.squaredNorm())) {
    int smallest;
    n.cwiseAbs().minCoeff(&smallest);
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(smallest);
    t = axis - n * n.dot(axis);
  }
  t.normalize();
  Eigen::Matrix3d frame;
  frame << n, t, n.cross(t);
  return frame;
}

}  // namespace finegauge
