#pragma once

#include <Eigen/Core>

#include "core/space/discretization.hpp"

namespace finegauge {

/// Reduced nodal forces of a motion, without a matrix.
struct TissueForces {
  Eigen::VectorXd internal;  ///< f_int(u) [N]
  Eigen::VectorXd stiff;     ///< K(u) w, rotations frozen at u [N for w in m]
};
/// One pass over the cells; u and w nodal, 3 × n_nodes. Springs are part of both, with their anchors at rest.
TissueForces tissue_forces(const Discretization& d, const Eigen::Matrix3Xd& u, const Eigen::Matrix3Xd& w);

/// What the anchors of springs add to the external forces of a step from t to t + τ, reduced [N]:
///   Σ_p k N_a (a(t + τ) + β (a(t + τ) - a(t))/τ),  β the stiffness damping [s].
Eigen::VectorXd anchor_loads(const Discretization& d, double stiffness_damping, double time, double tau);

/// m_i x_i per reduced node.
Eigen::VectorXd mass_times(const Eigen::VectorXd& mass, const Eigen::VectorXd& reduced);

}  // namespace finegauge
