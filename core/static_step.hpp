#pragma once

#include <vector>

#include "core/adapt/error_estimate.hpp"
#include "core/equilibrium.hpp"
#include "core/space/discretization.hpp"
#include "core/space/loads.hpp"

namespace finegauge {

/// A body in static equilibrium, but for its mesh.
struct StaticProblem {
  Material material;
  std::vector<SupportCondition> supports;
  std::vector<SurfaceLoad> loads;
  BodyForce body;
  EquilibriumOptions solver;
  std::vector<SpringSupport> springs = {};  ///< their anchors where they are at t = 0
  Estimator estimator = Estimator::spr;
};

/// Milliseconds of wall time of the stages of one step. Topology: mesh, T, patterns, hierarchy and the transfer of the
/// start; assembly includes the loads; the solve includes its set-up.
struct StaticTimes {
  double topology_ms = 0.0, assemble_ms = 0.0, reduce_ms = 0.0, solve_ms = 0.0, estimate_ms = 0.0;
};

/// One mesh, its solution and the solution's estimated error.
struct StaticSolution {
  Discretization discretization;
  Equilibrium equilibrium;
  ErrorEstimate estimate;
  StaticTimes times;
  int multigrid_levels = 0;
};

/// The static frame: mesh > T > patterns > (start from the solution before, or zero) > equilibrium > estimate.
StaticSolution solve_static(const RefinementForest& forest, const StaticProblem& problem, const StaticSolution* before,
                            FactorCache& factors);
/// The same for who has the forest's discretization, with the problem's material and supports, at hand; the time that
/// it took is the caller's.
StaticSolution solve_static(const RefinementForest& forest, Discretization discretization, const StaticProblem& problem,
                            const StaticSolution* before, FactorCache& factors);

}  // namespace finegauge
