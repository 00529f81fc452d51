#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/hanging_nodes.hpp"
#include "core/mesh/point_location.hpp"

namespace finegauge {

/// A contact point of the tissue, spread over the needle's radius: the mean of material points around it. Without that
/// a force on a line has no mesh limit (its displacement grows by f ln 2 / (2 π G) per halving of the cells). Weights
/// are positive and sum to one, and the mean of the rest positions is that of the centre, so that a linear field is
/// sampled exactly as by the centre alone.
struct SpreadPoint {
  MaterialPoint centre;
  std::vector<MaterialPoint> points;
  std::vector<double> weights;
};

/// Equal weights on a ring of `count` (even) points, radius [m] at rest across `rest_axis` (any length but zero).
/// Opposite points that are not both in the body are left out together; with none left, or with radius 0, the centre
/// alone.
/// A ring of n points is n forces of f / n: in cells much smaller than their distance, from about h = 5 r / n down, its
/// displacement grows again, by an n-th of the line's f ln 2 / (2 π G) per halving (verification/studies/line_force).
/// Eight points serve cells down to about half the radius.
SpreadPoint spread_over_ring(const BaseMesh& base, const MaterialPoint& centre, const Eigen::Vector3d& rest_axis,
                             double radius, int count = 8);

/// The point's interpolation in the nodes that do not hang: reduced numbers (HangingNodes), merged and ascending,
/// Σ weight = 1.
struct ReducedWeights {
  std::vector<int> node;
  std::vector<double> weight;
};
/// Overwrites `weights`; its storage is used again, so that no memory is asked for once it is large enough. `mesh` is
/// `forest.leaf_mesh()` of the forest as it is now, `hanging` belongs to it.
void find_reduced_weights(const RefinementForest& forest, const Mesh& mesh, const HangingNodes& hanging,
                          const SpreadPoint& point, ReducedWeights& weights);

/// Mean of a nodal field (3 × n_nodes) over the points.
Eigen::Vector3d spread_value(const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& nodal,
                             const SpreadPoint& point);
/// Mean current position (rest + u) [m].
Eigen::Vector3d spread_position(const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                const SpreadPoint& point);

}  // namespace finegauge
