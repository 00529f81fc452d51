#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/needle/needle.hpp"

namespace finegauge {

/// Dead loads at the nodes, six entries each [N, N m]; moments about global axes, of fixed direction in space.
struct NeedleLoad {
  Eigen::VectorXd fixed;      ///< present throughout; empty: none
  Eigen::VectorXd reference;  ///< multiplied by the load factor; empty: none
};

struct NeedleEquilibriumOptions {
  int steps = 1;        ///< equal increments of the load factor
  int iterations = 50;  ///< of Newton per step
  double residual = 1e-11;  ///< ‖free f_ext - f_int‖ / (largest of ‖f_ext‖, ‖f_int‖), moments over the needle's length
};

struct [[nodiscard]] NeedleEquilibrium {
  NeedleState state;               ///< of the last step that converged
  double load_factor = 0.0;        ///< reached; 1 when converged
  int iterations = 0;              ///< summed
  double relative_residual = 0.0;  ///< may stay above the one asked for where the round-off of the positions, EA |x| /
                                   ///< l times the unit round-off in each element, does not let it fall
  bool converged = false;
  int negative_pivots = 0;  ///< of the tangent there: > 0 on an unstable branch, -1 where it is singular
};

/// Static equilibrium from a start state by Newton's method with the symmetric part of the full tangent, increment by
/// increment. Held dofs stay where the start state has them. Velocities are ignored and returned zero. Quadratic
/// convergence, but linear where applied moments turn the needle out of their plane: the tangent's skew part is theirs,
/// and where it alone resists (a moment of π EI / L at the tip, no out-of-plane dof held) a step that starts there
/// fails.
NeedleEquilibrium solve_needle_equilibrium(const Needle& needle, const HeldDofs& held, const NeedleLoad& load,
                                           const NeedleState& start, const NeedleEquilibriumOptions& options = {});

/// A point of an equilibrium path.
struct PathPoint {
  double load_factor;
  NeedleState state;
  int negative_pivots;  ///< of the tangent there, -1 where it is singular
};
struct ArcLengthOptions {
  double length = 0.05;  ///< of a step, in units of the norm of the first linear response to the whole load
  int points = 200;      ///< at most, the start included
  int iterations = 20;   ///< of Newton per step; a step that needs more is halved, at most twenty times in a row
  double residual = 1e-10;
};
struct [[nodiscard]] EquilibriumPath {
  std::vector<PathPoint> points;  ///< the first is the start, at load factor 0
  bool stalled = false;           ///< a step failed however short: the path ends early
};
/// The equilibrium path by the arc-length method (Crisfield 1981), through limit points; stops after `points` or where
/// `enough` says so. The length of a step is that of the translations of all nodes; the path goes on in the direction
/// in which it came (Feng et al. 1996). The start is an equilibrium under the fixed load.
EquilibriumPath follow_equilibrium_path(const Needle& needle, const HeldDofs& held, const NeedleLoad& load,
                                        const NeedleState& start, const ArcLengthOptions& options,
                                        const std::function<bool(const PathPoint&)>& enough);

}  // namespace finegauge
