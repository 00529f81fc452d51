#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/solve/conjugate_gradients.hpp"
#include "core/solve/multigrid.hpp"
#include "core/space/assembly.hpp"
#include "core/space/loads.hpp"

namespace finegauge {

enum class LinearMethod { direct, multigrid, automatic };

struct EquilibriumOptions {
  LinearMethod method = LinearMethod::automatic;
  IterationLimits linear;  ///< of each linear solve
  int newton_iterations = 50;
  double newton_residual = 1e-8;  ///< ‖free part of f_ext - f_int‖ / ‖f_ext or reactions‖ (corotational only)
};

/// The method that `automatic` stands for: direct where there is no coarser mesh or nu > 0.45 (Gauss-Seidel smoothing
/// degrades as nu -> 1/2), else multigrid.
LinearMethod choose_method(const Discretization& d, const MeshHierarchy& hierarchy, LinearMethod asked);

/// Milliseconds of wall time per stage.
struct StageTimes {
  double assemble_ms = 0.0, reduce_ms = 0.0, solve_ms = 0.0;
};

struct [[nodiscard]] Equilibrium {
  Eigen::Matrix3Xd u;  ///< nodal displacement [m]
  bool converged = false;
  int newton_iterations = 0;
  int linear_iterations = 0;  ///< summed over Newton
  double relative_residual = 0.0;
  double energy = 0.0;  ///< ∫ ε:σ [J], second-order accurate in the algebraic error for linear problems
  StageTimes times;
};

/// Static equilibrium under nodal loads [N] from a start displacement, by Newton with frozen rotations and a line
/// search; linear materials take one step. `hierarchy` belongs to the discretization.
Equilibrium solve_equilibrium(const Discretization& d, const MeshHierarchy& hierarchy, const Eigen::Matrix3Xd& loads,
                              const Eigen::Matrix3Xd& start, const EquilibriumOptions& options = {});

}  // namespace finegauge
