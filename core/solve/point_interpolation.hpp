#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/space/supports.hpp"

namespace finegauge {

/// The weights of one point in the nodes that do not hang: reduced numbers, ascending.
struct PointWeights {
  std::span<const int> node;
  std::span<const double> weight;
};

/// B, 3 P × n: P points sampled from a reduced vector x, (B x)_p = Σ w_i Z_i x_i. Z_i takes the held directions out, so
/// that B and Bᵀ act on free directions only. Stored by point: one weight serves three components.
struct PointInterpolation {
  std::vector<int> start;  ///< P + 1, into the others
  std::vector<int> node;
  std::vector<double> weight;
  std::vector<int> support;           ///< entry of `held` that belongs to the node, -1: none
  std::vector<Eigen::Matrix3d> held;  ///< projectors onto held directions of the nodes that have some

  int point_count() const { return start.empty() ? 0 : static_cast<int>(start.size()) - 1; }
};
/// `B` is overwritten, its buffers are used again.
void interpolate_points(std::span<const PointWeights> points, const Supports& supports, PointInterpolation& B);

/// (B x)_p, and with the held directions left in.
Eigen::Vector3d sample_free(const PointInterpolation& B, int point, const Eigen::VectorXd& x);
Eigen::Vector3d sample_all(const PointInterpolation& B, int point, const Eigen::VectorXd& x);
/// y += B_pᵀ f.
void add_spread(const PointInterpolation& B, int point, const Eigen::Vector3d& f, Eigen::VectorXd& y);
/// Whether the points have the same nodes, weights and held directions, to the last bit.
bool same_point(const PointInterpolation& A, int a, const PointInterpolation& B, int b);

}  // namespace finegauge
