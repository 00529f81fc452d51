#pragma once

#include <Eigen/Core>
#include <optional>

#include "benchmarks/profile/tjunction_overhead.hpp"
#include "benchmarks/program/static_run.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// A mesh of a run with the displacement on it.
struct MeshMoment {
  RefinementForest forest;
  Discretization d;
  Eigen::Matrix3Xd u;  ///< [m]
};

/// The T-junction ledger of a scene: on the mesh of the run with the most hanging nodes the counts and the cost of each
/// handling, and of the mesh that has no hanging nodes since all of it is as fine as that one's finest cells: at least
/// as accurate, so that it bounds what a conforming mesh of the same accuracy costs (`finegauge reproduce tjunctions`
/// compares at equal error). Of a moving scene also what hanging nodes take of its frames.
Json tjunction_summary(const std::optional<MeshMoment>& most, const TjunctionOverhead* overhead, int repetitions);
/// Largest difference between displacements of the handlings that solve the problem; none where none was compared.
std::optional<double> handling_difference(const Json& summary);

/// All base cells refined as deep as the deepest leaf, each level by the template that the first cell refined there
/// has.
RefinementForest uniformly_refined_like(const RefinementForest& forest);

}  // namespace finegauge
