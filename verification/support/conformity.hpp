#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

/// The largest difference between the values that a nodal field takes in two leaves at one point of both, over random
/// points on every face and every edge of every leaf: zero for a conforming field. An oracle for T that knows nothing
/// of hanging nodes: it only locates points and interpolates.
double largest_jump(const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& nodal,
                    int points_per_face, std::uint64_t seed);

}  // namespace finegauge
