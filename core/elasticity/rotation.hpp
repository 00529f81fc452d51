#pragma once

#include <Eigen/Core>

namespace finegauge {

/// The rotation nearest to F (polar decomposition; Higham 1986). Always a proper rotation: a flat cell (det F = 0) or
/// an inverted one (det F < 0) gets the proper rotation that maximizes tr(Rᵀ F), by reversing the smallest singular
/// value; F = 0 gets the identity. Uses no earlier rotation, so half turns are as good as any other.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& F);

}  // namespace finegauge
