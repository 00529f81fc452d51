#include "core/solve/point_interpolation.hpp"

#include <algorithm>
#include <cassert>

namespace finegauge {

void interpolate_points(std::span<const PointWeights> points, const Supports& supports, PointInterpolation& B) {
  B.start.assign(1, 0);
  B.node.clear();
  B.weight.clear();
  B.support.clear();
  B.held.clear();
  for (const PointWeights& point : points) {
    assert(point.node.size() == point.weight.size());
    for (std::size_t k = 0; k < point.node.size(); ++k) {
      const auto found = std::lower_bound(supports.reduced.begin(), supports.reduced.end(), point.node[k]);
      const bool supported = found != supports.reduced.end() && *found == point.node[k];
      B.node.push_back(point.node[k]);
      B.weight.push_back(point.weight[k]);
      B.support.push_back(supported ? static_cast<int>(B.held.size()) : -1);
      if (supported) B.held.push_back(supports.held[static_cast<std::size_t>(found - supports.reduced.begin())]);
    }
    B.start.push_back(static_cast<int>(B.node.size()));
  }
}

Eigen::Vector3d sample_free(const PointInterpolation& B, int point, const Eigen::VectorXd& x) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = B.start[point]; k < B.start[point + 1]; ++k) {
    const Eigen::Vector3d x_i = x.segment<3>(3 * B.node[k]);
    if (B.support[k] < 0)
      sum += B.weight[k] * x_i;
    else
      sum += B.weight[k] * (x_i - B.held[B.support[k]] * x_i);
  }
  return sum;
}

Eigen::Vector3d sample_all(const PointInterpolation& B, int point, const Eigen::VectorXd& x) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = B.start[point]; k < B.start[point + 1]; ++k) sum += B.weight[k] * x.segment<3>(3 * B.node[k]);
  return sum;
}

void add_spread(const PointInterpolation& B, int point, const Eigen::Vector3d& f, Eigen::VectorXd& y) {
  for (int k = B.start[point]; k < B.start[point + 1]; ++k) {
    const Eigen::Vector3d share = B.weight[k] * f;
    if (B.support[k] < 0)
      y.segment<3>(3 * B.node[k]) += share;
    else
      y.segment<3>(3 * B.node[k]) += share - B.held[B.support[k]] * share;
  }
}

bool same_point(const PointInterpolation& A, int a, const PointInterpolation& B, int b) {
  const int size = A.start[a + 1] - A.start[a];
  if (size != B.start[b + 1] - B.start[b]) return false;
  for (int k = 0; k < size; ++k) {
    const int i = A.start[a] + k, j = B.start[b] + k;
    if (A.node[i] != B.node[j] || A.weight[i] != B.weight[j] || (A.support[i] < 0) != (B.support[j] < 0)) return false;
    if (A.support[i] >= 0 && A.held[A.support[i]] != B.held[B.support[j]]) return false;
  }
  return true;
}

}  // namespace finegauge
