#pragma once

#include <Eigen/Core>

#include "core/space/discretization.hpp"

namespace finegauge {

/// Reduced nodal forces of a motion, without a matrix.
struct TissueForces {
  Eigen::VectorXd internal;  ///< f_int(u) [N]
  Eigen::VectorXd stiff;     ///< K(u) w, rotations frozen at u [N for w in m]
};
/// One pass over the cells; u and w nodal, 3 × n_nodes.
TissueForces tissue_forces(const Discretization& d, const Eigen::Matrix3Xd& u, const Eigen::Matrix3Xd& w);

/// m_i x_i per reduced node.
Eigen::VectorXd mass_times(const Eigen::VectorXd& mass, const Eigen::VectorXd& reduced);

}  // namespace finegauge
