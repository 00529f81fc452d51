#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/elasticity/material.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// A linear static solution and its recovered stresses.
struct SolvedBody {
  Discretization d;
  Eigen::Matrix3Xd u;                                     ///< nodal displacement [m]
  Eigen::Matrix<double, 6, Eigen::Dynamic> nodal_stress;  ///< recover_stress_spr, 6 × n_nodes [Pa]
  double relative_residual = 0.0;                         ///< of the solve
};

/// Nodal forces [N], 3 × n_nodes, of the forest's leaf mesh.
using NodalLoads = std::function<Eigen::Matrix3Xd(const BaseMesh& base, const Mesh& mesh)>;

/// Solves to a relative residual of 1e-9, far below any discretization error that a study tells, by the direct method
/// or by multigrid where the forest is refined. Throws std::runtime_error when that fails: without a solution there is
/// no number.
SolvedBody solve_body(const RefinementForest& forest, const Material& material,
                      const std::vector<SupportCondition>& supports, const NodalLoads& loads);

}  // namespace finegauge
