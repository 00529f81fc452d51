#include "core/needle/tissue_coupling.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace finegauge {
namespace {

/// The material point at X, if X is in the body to round-off and not only to the slack of the location: one that had
/// to be moved would move the ring's centre.
std::optional<MaterialPoint> locate_exactly(const BaseMesh& base, const Eigen::Vector3d& X, int hint) {
  const std::optional<MaterialPoint> found = locate_at_rest(base, X, hint);
  if (!found) return std::nullopt;
  double size = X.cwiseAbs().maxCoeff();
  for (int c = 0; c < corner_count(base.shape); ++c)
    size = std::max(size, base.nodes.col(base.cells[found->base_cell][c]).cwiseAbs().maxCoeff());
  const double difference = (rest_position(base, *found) - X).cwiseAbs().maxCoeff();
  if (difference > 64.0 * std::numeric_limits<double>::epsilon() * size) return std::nullopt;
  return found;
}

void add_weight(int node, double weight, ReducedWeights& weights) {
  const auto place = std::lower_bound(weights.node.begin(), weights.node.end(), node);
  const auto at = place - weights.node.begin();
  if (place != weights.node.end() && *place == node) {
    weights.weight[at] += weight;
    return;
  }
  weights.node.insert(place, node);
  weights.weight.insert(weights.weight.begin() + at, weight);
}

}  // namespace

SpreadPoint spread_over_ring(const BaseMesh& base, const MaterialPoint& centre, const Eigen::Vector3d& rest_axis,
                             double radius, int count) {
  assert(count >= 2 && count % 2 == 0 && radius >= 0.0 && rest_axis.squaredNorm() > 0.0);
  SpreadPoint spread{centre, {}, {}};
  if (radius > 0.0) {
    const Eigen::Vector3d axis = rest_axis.stableNormalized();
    const Eigen::Vector3d e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
    const Eigen::Vector3d X = rest_position(base, centre);
    spread.points.reserve(count);
    for (int k = 0; k < count / 2; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / count;
      const Eigen::Vector3d offset = radius * (std::cos(angle) * e1 + std::sin(angle) * e2);
      const auto near = locate_exactly(base, X + offset, centre.base_cell);
      const auto far = near ? locate_exactly(base, X - offset, centre.base_cell) : std::nullopt;
      if (!far) continue;
      spread.points.push_back(*near);
      spread.points.push_back(*far);
    }
  }
  if (spread.points.empty()) spread.points.push_back(centre);
  spread.weights.assign(spread.points.size(), 1.0 / static_cast<double>(spread.points.size()));
  return spread;
}

void find_reduced_weights(const RefinementForest& forest, const Mesh& mesh, const HangingNodes& hanging,
                          const SpreadPoint& point, ReducedWeights& weights) {
  weights.node.clear();
  weights.weight.clear();
  for (std::size_t k = 0; k < point.points.size(); ++k) {
    const LeafPoint leaf = find_leaf(forest, mesh, point.points[k]);
    const auto N = shape_functions(mesh.shape, leaf.xi);
    for (int c = 0; c < corner_count(mesh.shape); ++c) {
      if (N[c] == 0.0) continue;  // a point on a face needs the face's nodes only
      const int node = mesh.cells[leaf.cell][c];
      for (int row = hanging.row_start[node]; row < hanging.row_start[node + 1]; ++row)
        add_weight(hanging.master[row], point.weights[k] * N[c] * hanging.weight[row], weights);
    }
  }
}

Eigen::Vector3d spread_value(const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& nodal,
                             const SpreadPoint& point) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < point.points.size(); ++k)
    mean += point.weights[k] * interpolate(mesh, nodal, find_leaf(forest, mesh, point.points[k]));
  return mean;
}

Eigen::Vector3d spread_position(const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                const SpreadPoint& point) {
  return spread_value(forest, mesh, mesh.nodes, point) + spread_value(forest, mesh, u, point);
}

}  // namespace finegauge
