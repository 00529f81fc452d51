#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/solve/conjugate_gradients.hpp"
#include "core/solve/multigrid.hpp"
#include "core/space/assembly.hpp"
#include "core/space/loads.hpp"

namespace finegauge {

/// Conjugate gradients with multigrid stop where the residual is what the options ask for, and the last iteration
/// changed the strain of no cell by more than this many times the relative residual, relative to the body's mean strain
/// sqrt(∫ε:σ / (E V)). The residual adds up the nodes' forces, and those of a small cell are as small as its faces;
/// the energy norm is blinder still, since the cell's energy is as small as its volume. At the usual residual of 1e-6
/// that leaves a thousandth, a tenth of the discretization error of a mesh that is right to a per cent.
inline constexpr double strain_per_residual = 1000.0;

enum class LinearMethod { direct, multigrid, automatic };

struct EquilibriumOptions {
  LinearMethod method = LinearMethod::automatic;
  IterationLimits linear;  ///< of each linear solve
  int newton_iterations = 50;
  double newton_residual = 1e-8;  ///< ‖free f_ext - f_int‖ / larger of ‖free f_ext‖, ‖f_int‖ (corotational only)
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
  double relative_residual =
      0.0;              ///< may stay above newton_residual where round-off of the positions does not let it fall
  double energy = 0.0;  ///< ∫ ε:σ [J], without springs; second-order accurate in the algebraic error for linear
                        ///< problems that have no springs and prescribe no displacement
  StageTimes times;
};

/// Static equilibrium under nodal loads [N] from a start displacement. Linear materials take one step. Corotational
/// ones iterate with frozen rotations, each step taken whole and mixed with the ones before (anderson_mixing.hpp): the
/// matrix stays symmetric positive definite, and cantilevers bend by more than their length's half in some 15 steps.
/// Where several equilibria exist (buckled or not) the one found need not be the stable one. Not converged: u is the
/// last iterate. `hierarchy` belongs to the discretization. Anchors of springs are where they are at t = 0.
Equilibrium solve_equilibrium(const Discretization& d, const MeshHierarchy& hierarchy, const Eigen::Matrix3Xd& loads,
                              const Eigen::Matrix3Xd& start, const EquilibriumOptions& options = {},
                              FactorCache* factors = nullptr);

}  // namespace finegauge
