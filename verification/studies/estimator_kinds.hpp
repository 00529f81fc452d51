#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/adapt/error_estimate.hpp"
#include "verification/support/evidence.hpp"

namespace finegauge {

/// What an estimate is made of. Each kind has rungs of its own on the ladder, since an effectivity that was measured on
/// one kind says nothing of another.
enum class ProblemKind {
  hexahedra,   ///< linear strains, hexahedra full of material (estimator_ladder.hpp)
  tetrahedra,  ///< linear strains
  cut_cells,   ///< linear strains, hexahedra that a smooth surface leaves partly filled
  rotated,     ///< corotational, at rest, whose cells turn by tens of degrees
  moving,      ///< frames of a motion
  line_force   ///< forces on a line or in points, as a needle's are
};

/// Between which bounds the estimated over the true error of Estimator::spr_edges lies on every rung of the kind: the
/// ladder gates it. None for forces on a line, which have no true error (line_force_errors).
struct EffectivityRange {
  double low, high;
};
std::optional<EffectivityRange> effectivity_range(ProblemKind kind);
/// By what the range that a run prints is wider at both ends, since the rungs are not all problems (holdout.hpp).
inline constexpr double certificate_margin = 1.05;
std::string rungs_of(ProblemKind kind);  ///< what the range rests on, in words

struct KindRow {
  ProblemKind kind;
  std::string rung;
  int cells = 0, dofs = 0;
  double true_error = 0.0;            ///< over the energy norm of the computed solution, as η is
  double spr = 0.0, spr_edges = 0.0;  ///< effectivities
};
/// tetrahedra_rungs (estimator_rungs.hpp).
std::vector<KindRow> tetrahedra_rows();
/// The unit cube up to an oblique plane, which cuts the cells; the exact stress.
std::vector<KindRow> cut_rows();
/// A bar that bends and a block that is twisted, against the same on cells halved twice: the distance of the stresses,
/// and the squares of the reference's own estimate, at most a tenth of it.
std::vector<KindRow> rotated_rows();
/// A bar that falls and swings, on a mesh that stays and on one that follows it, against the same steps on cells halved
/// twice.
std::vector<KindRow> moving_rows();

/// A force on a line of nodes through a plate: the energy of its exact solution is infinite.
struct LineForceErrors {
  std::vector<double> effectivity;  ///< of one mesh, by the reference's halvings of the cells at the line: 1, 2, ...
  std::vector<double>
      rise;  ///< of the energy from one reference to the next, over what theory has, f² L ln 2 / (2 π G)
};
LineForceErrors line_force_errors(int halvings);

/// Tables and claims of all kinds but the first.
void add_kinds(const EvidenceOptions& options, Evidence& evidence);

}  // namespace finegauge
