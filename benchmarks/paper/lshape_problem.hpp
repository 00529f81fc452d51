#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/elasticity/material.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/space/loads.hpp"
#include "core/space/supports.hpp"

namespace finegauge {

/// The quadrant that the L-shape lacks; lower means small y, left small x.
enum class NotchCorner { lower_left, lower_right, upper_left, upper_right };

/// What the paper leaves open about its L-shape. The defaults are the reading that has the paper's slope.
struct LshapeOptions {
  int cells_per_edge = 8;  ///< base cells along x and y, half as many along z; even
  NotchCorner notch = NotchCorner::lower_right;
  std::string clamped = "x_max";       ///< surface held in all directions
  std::string roller = "y_max";        ///< box surface held along its normal; empty: none
  std::string loaded = "x_min";        ///< surface under traction
  Eigen::Vector3d traction{-1, 0, 0};  ///< force per area, dimensionless as the whole problem
  Material material;                   ///< E = 1e3, nu = 0.3
};

/// A block of 4 × 4 × 2 without one quadrant, for static equilibrium.
struct LshapeProblem {
  RefinementForest forest;
  Material material;
  std::vector<SupportCondition> supports;
  std::vector<SurfaceLoad> loads;
};

/// Throws std::invalid_argument when cells_per_edge is not even and positive, or a surface does not exist.
LshapeProblem lshape_problem(const LshapeOptions& options = {});

}  // namespace finegauge
