#pragma once

#include <string>
#include <vector>

#include "core/static_step.hpp"
#include "verification/support/evidence.hpp"
#include "verification/support/exact_field.hpp"

namespace finegauge {

/// Problems that the certified range of a run does not rest on: what it is worth beyond its own ladder
/// (estimator_ladder.hpp), of which none is a rung. The known ones were looked at while `spr_edges` was made, some of
/// its constants fitted to their like, so that what they show can have been chosen by what they showed. The drawn ones
/// are blind: their geometry, material, loads and mixture of modes come from a random generator with a fixed seed, and
/// nothing was changed after a look.
struct HoldoutProblem {
  std::string family, name;
  BaseMesh mesh;
  StaticProblem problem;
  /// The truth where it has a stress; the solution then is prescribed on surfaces. Otherwise the truth is that of a
  /// graded reference mesh (ReferenceEnergy).
  ExactField exact = {};
  bool drawn = false;
  /// Why `finegauge run` would print no range for such a scene (benchmarks/program/certificate.hpp); empty: it would.
  std::string refused = {};
  std::string weakness = {};  ///< what of it the estimator is known not to follow; empty: nothing
};

std::vector<HoldoutProblem> known_holdout_problems();
std::vector<HoldoutProblem> drawn_holdout_problems();

inline const std::string refused_mesh = "not a box", refused_load = "load on part of a face",
                         refused_cells = "stretched cells at an edge", refused_between = "load between clamped faces",
                         drawn_load = "drawn load on a part";

/// A wedge (verification/support/wedge_mesh.hpp) with the exact displacement around it, in plane strain.
void hold_outside(HoldoutProblem& wedge);

/// Whether a problem is solved in tetrahedra too, six in a cell: those of full stiffness up to the Poisson ratio where
/// runs stop to print a range of tetrahedra, but for what the estimator is known to miss in hexahedra for other reasons
/// than the lengths of cells at an edge.
bool is_for_tetrahedra(const HoldoutProblem& problem);

/// One mesh of one problem.
struct HoldoutRow {
  std::string mesh;
  CellShape shape = CellShape::hexahedron;
  int cells = 0, dofs = 0;
  double true_error = 0.0;   ///< relative to the energy norm of the solution, as η is
  double uncertainty = 0.0;  ///< half the width of what the truth is known to, over the truth; zero for exact fields
  double spr = 0.0, spr_edges = 0.0;
  double equilibrated = 0.0;  ///< zero: not asked for, or refused
};

/// Twice the potential energy, ∫ ε:σ - 2 F·u, of a graded mesh, and between which bounds the square of its own error
/// lies. On any conforming mesh ‖e‖² is its own less that of the reference, and the square of the reference's error: at
/// most that of its equilibrated estimate and at least a quarter, as the ladder gates that estimator, which is not the
/// one under test.
struct ReferenceEnergy {
  double twice_potential = 0.0, least_error_squared = 0.0, most_error_squared = 0.0;
  int dofs = 0;
};

struct HoldoutOptions {
  /// Meshes after the base mesh: refined by the estimate once, twice and four times, and all cells halved. Small base
  /// meshes are solved in tetrahedra in any case, all with this.
  bool all_meshes = true;
  int reference_dofs = 60000;  ///< beyond which the reference is not refined
};
/// Solves and estimates. Throws std::runtime_error where a solve does not converge.
std::vector<HoldoutRow> measure(const HoldoutProblem& problem, const HoldoutOptions& options);

Evidence holdout_evidence(const EvidenceOptions& options);

}  // namespace finegauge
