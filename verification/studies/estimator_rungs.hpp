#pragma once

#include <string>
#include <vector>

#include "core/static_step.hpp"
#include "verification/support/exact_field.hpp"

namespace finegauge {

/// A problem whose true error is known, of linear strains in cells full of material.
struct LadderRung {
  std::string name;
  RefinementForest forest;
  StaticProblem problem;
  ExactField exact;           ///< without a stress: the energy alone is known
  double exact_energy = 0.0;  ///< ∫ ε:σ [J] of the exact solution where there is no stress
  int refinements = 0;        ///< steps of refinement 2x2x2 by the maximum strategy, θ = 1/2, plain SPR
  bool singular = false;      ///< the stress is unbounded somewhere
  bool has_front = false;     ///< refined cells meet others
};

/// Every rung in hexahedra, in the order of the table; `full` adds finer grids.
std::vector<LadderRung> ladder_rungs(bool full = false);
/// Those in tetrahedra: six in a cube, along its diagonal. Of an edge it matters whether diagonals meet it, so that a
/// notch and a rim come in both ways.
std::vector<LadderRung> tetrahedra_rungs();

/// After the rung's refinements. Throws std::runtime_error where a solve does not converge.
StaticSolution solve(LadderRung& rung);
/// Of the rung's solution: by cells where the exact stress is known.
TrueError true_error_of(const LadderRung& rung, const StaticSolution& solution, const ErrorEstimate& spr);

}  // namespace finegauge
