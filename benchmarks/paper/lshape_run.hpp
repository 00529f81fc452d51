#pragma once

#include <functional>
#include <string>
#include <vector>

#include "benchmarks/paper/lshape_problem.hpp"
#include "core/adapt/directional_marking.hpp"
#include "core/static_step.hpp"

namespace finegauge {

/// How a sequence of meshes comes about.
enum class LshapeScheme {
  uniform,      ///< 2×2×2 everywhere
  adaptive,     ///< the paper's: 2×2×2 where η_e >= θ max η
  directional,  ///< templates by the direction of the error
};
std::string to_string(LshapeScheme scheme);

/// One mesh of a sequence. Times in milliseconds; topology and marking are those that led to this mesh.
struct LshapeStep {
  LshapeScheme scheme;
  int step = 0, cells = 0, nodes = 0, hanging_nodes = 0, dofs = 0, iterations = 0;
  bool converged = false;
  double eta = 0.0;
  double estimated_error = 0.0;  ///< absolute, [√J]
  double energy = 0.0;           ///< ∫ ε:σ
  double estimate_ms = 0.0, mark_ms = 0.0, topology_ms = 0.0, assemble_ms = 0.0, reduce_ms = 0.0, solve_ms = 0.0;

  /// All that this mesh costs on the way: a uniform mesh needs no estimate and no marks.
  double total_ms() const {
    const double solution = topology_ms + assemble_ms + reduce_ms + solve_ms;
    return scheme == LshapeScheme::uniform ? solution : solution + estimate_ms + mark_ms;
  }
};

struct LshapeRunOptions {
  LshapeOptions problem;
  EquilibriumOptions solver;
  double theta = 0.3;              ///< of the adaptive scheme
  DirectionalMarking directional;  ///< of the directional scheme
  int enough_dofs = 40000;         ///< a sequence ends with the first mesh that has as many
};

/// What leads from a mesh to the next: all cells, the maximum strategy's, or each with a template of its own.
std::vector<Refinement> choose_refinements(LshapeScheme scheme, const LshapeRunOptions& options,
                                           const StaticSolution& solution);

/// Told of every mesh; false ends the sequence.
using LshapeObserver = std::function<bool(const LshapeStep&, const StaticSolution&)>;

std::vector<LshapeStep> run_lshape(LshapeScheme scheme, const LshapeRunOptions& options,
                                   const LshapeObserver& observer);

}  // namespace finegauge
