#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/program/certificate.hpp"
#include "benchmarks/program/result_document.hpp"
#include "core/adapt/error_estimate.hpp"
#include "core/equilibrium.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/scene/scene.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// One solve of the adaptive loop: a row of the result.
struct StaticStep {
  int step = 0, cells = 0, nodes = 0, hanging_nodes = 0;
  int dofs = 0;                             ///< 3 × nodes that do not hang, prescribed ones included
  double eta = 0.0;                         ///< estimated relative error in the energy norm
  double eta_local_max = 0.0;               ///< largest η_e over the energy norm of the whole solution
  std::optional<CertifiedRange> certified;  ///< of the error
  std::string uncertified;                  ///< why there is no range
  bool tolerance_met = false;               ///< false without a tolerance
  bool converged = false;
  double residual = 0.0;                      ///< relative
  int iterations = 0, newton_iterations = 0;  ///< of the linear solver, summed over Newton's
  double strain_energy = 0.0;                 ///< half of ∫ ε:σ [J]
  Json quantities = Json::object();           ///< of interest, by name; displacements as [x, y, z]
  double topology_ms = 0.0, assemble_ms = 0.0, reduce_ms = 0.0, solve_ms = 0.0, estimate_ms = 0.0, mark_ms = 0.0;
  double total_ms = 0.0;  ///< sum of the stages
};
Json to_json(const StaticStep& step);

/// What an observer sees after each step.
struct StaticView {
  const StaticStep& step;
  const RefinementForest& forest;
  const Discretization& discretization;
  const Eigen::Matrix3Xd& u;  ///< [m]
  const ErrorEstimate& estimate;
  bool last;  ///< no further step follows, unless the observer is what stops it
};
using StaticObserver = std::function<bool(const StaticView&)>;  ///< false: stop here

struct StaticRun {
  std::vector<StaticStep> steps;
  int refined = 0;  ///< cells refined by the loop
  std::string stopped_because;
  Eigen::Matrix3Xd u;              ///< final nodal displacement [m]
  std::vector<std::string> notes;  ///< on the final solution (static_notes.hpp)
};

/// Solve, estimate, mark, refine, again, each solve started from the last one's field on the new mesh. A scene without
/// adaptivity is one step. Ends after a step that did not converge. Throws SceneError, before the first solve, when the
/// body is not held or a quantity's point is not in it.
StaticRun run_static(const Scene& scene, const StaticObserver& observer);

}  // namespace finegauge
