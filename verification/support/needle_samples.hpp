#pragma once

#include <Eigen/Core>
#include <random>

#include "core/needle/chain_matrix.hpp"
#include "core/needle/needle.hpp"
#include "verification/support/sample_cells.hpp"

namespace finegauge {

/// The needle displaced and turned by up to `size` everywhere.
inline NeedleState sample_state(const Needle& needle, double size, std::mt19937& generator) {
  NeedleState state = needle_at_rest(needle);
  Eigen::VectorXd increment(needle.dof_count());
  for (Eigen::Index i = 0; i < increment.size(); ++i) increment[i] = size * random_number(generator);
  displace(increment, state);
  return state;
}

/// The same matrix with all of its zeros, 6n × 6n.
inline Eigen::MatrixXd dense(const ChainMatrix& A) {
  const int n = A.node_count();
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  for (int i = 0; i < n; ++i) {
    D.block<6, 6>(6 * i, 6 * i) = A.diagonal[i];
    if (i + 1 == n) break;
    D.block<6, 6>(6 * i, 6 * i + 6) = A.upper[i];
    D.block<6, 6>(6 * i + 6, 6 * i) = A.upper[i].transpose();
  }
  return D;
}

}  // namespace finegauge
