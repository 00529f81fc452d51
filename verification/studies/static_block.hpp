#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/elasticity/material.hpp"

namespace finegauge {

/// The block 0.04 × 0.02 × 0.02 m, clamped at x = 0, 40 N along -y shared equally by the nodes of the far face; E =
/// 10 MPa, nu = 0.4.
struct BlockRow {
  std::array<int, 3> nodes;
  Kinematics kinematics = Kinematics::linear;
  Eigen::Vector3d face_mean = Eigen::Vector3d::Zero();  ///< mean displacement of the far face's nodes [m]
  double mean_length = 0.0;                             ///< mean of |u| over all nodes [m]
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();     ///< displacement of (0.04, 0.02, 0.02) [m]
  double residual = 0.0;
  Eigen::Matrix3Xd rest, u;  ///< nodes, for oracles
  bool converged = false;
};
BlockRow solve_block(const std::array<int, 3>& nodes, Kinematics kinematics);
std::string block_table(const std::vector<BlockRow>& rows);

}  // namespace finegauge
