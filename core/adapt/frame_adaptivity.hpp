#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/adapt/error_estimate.hpp"
#include "core/adapt/marking.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

/// How a mesh follows its solution in time. The paper has one threshold for both ways (section on marking); with it a
/// cell whose error lies near the threshold is refined and coarsened in turns, hence two, and a dwell time.
///
/// Without a tolerance the rule is the paper's, with two thresholds: refine where the error is large and the stress
/// rises, coarsen where it is small and the stress falls. With a tolerance, of the global error or of the largest local
/// one, the error is what counts and not the sign of a rate: cells are refined until the tolerance is met or the depth
/// limit is reached, and go when it is over-met (tolerance_marking.hpp).
///
/// Dwell holds back coarsening only. Refinement answers an error that is there now and is never late; so a cell may be
/// refined right after it was coarsened to, and then stays refined for `dwell` frames: at most one such turn per dwell.
struct FrameAdaptRules {
  double refine_above = 0.3;  ///< θ_r in (0, 1]: refine where η_e >= θ_r max η and the stress rises
  double coarsen_below = 0.05;  ///< θ_c in [0, θ_r]: coarsen where sqrt(Σ η_e²) <= θ_c max η over a family, none rising
  double tolerance = 0.0;        ///< of the relative error η; 0: not asked
  double local_tolerance = 0.0;  ///< of the largest η_e over the energy norm of the body; 0: not asked
  double refine_at = 0.9;   ///< share of a tolerance, in (0, 1], at which refinement sets in: a frame's growth of the
                            ///< error is answered before it is a miss
  double coarsen_at = 0.7;  ///< share of a tolerance, in [0, refine_at), that the error predicted after a coarsening
                            ///< may have: the hysteresis
  double energy_floor = 0.0;  ///< a body with ∫ ε:σ below this [J] is at rest: each family that has dwelt is coarsened,
                              ///< whatever its stress does and however its error, a share of almost nothing, compares
  int dwell = 10;            ///< frames for which a cell that was made is not coarsened, >= 0
  int every = 1;             ///< frames from one marking to the next, >= 1
  int release = 0;           ///< frames over which what a change of mesh alters in the forces is spread, >= 0
                             ///< (mesh_change_release.hpp); 0 and 1: all in the next frame
  int max_depth = 1;         ///< of a leaf; a division by 4 counts as two levels (apply_refinements.hpp)
  int max_dofs = 0;          ///< never exceeded by refinement: the worst cells come first; 0: no bound
  bool directional = false;  ///< templates by the direction of the error (directional_marking.hpp, theta = θ_r),
                             ///< in thirds where `refinement` has one, else in halves and quarters; or `refinement`
  RefinementTemplate refinement = {};
};

/// Throws std::invalid_argument with field, value and range.
void check(const FrameAdaptRules& rules);

/// Whether the frame is one of those that are marked; in others neither estimate nor stress is needed.
inline bool marks_in_frame(int frame, const FrameAdaptRules& rules) { return frame % rules.every == 0; }

/// What marking remembers of the leaves from one marking to the next, by forest handle; entries of cells that are gone
/// or no leaves are empty. Belongs to one forest, which only `adapt_forest` changes.
struct FrameAdaptHistory {
  static constexpr int long_ago = -(1 << 30);

  std::vector<double> von_mises;        ///< per handle, at the last marking [Pa]; negative: none
  std::vector<int> changed;             ///< per handle, frame in which the leaf was made; long_ago: was always there
  std::vector<std::uint8_t> coarsened;  ///< per handle, 1 where the leaf was made by coarsening
  int toggle_window = 10;               ///< [frames]; a yardstick of its own, so that rules with any dwell compare
  int toggles = 0;  ///< changes taken back within fewer frames than the window: families coarsened that were refined,
                    ///< cells refined that were coarsened to
};

/// Whether a tolerance is asked for.
inline bool asks_for_tolerance(const FrameAdaptRules& rules) {
  return rules.tolerance > 0.0 || rules.local_tolerance > 0.0;
}
/// η over its tolerance, or the largest η_e over the energy norm over its own if that is more: above 1 one of them is
/// missed, by this factor. Zero where none is asked or there is no error, infinite for an error without energy.
double tolerance_ratio(const ErrorEstimate& estimate, const FrameAdaptRules& rules);

/// What kept a frame from refining as much as its tolerance asked for.
enum class AdaptLimit { none, depth, dofs };

struct FrameMarks {
  std::vector<Refinement> refine;       ///< leaves by cell number of the mesh, ascending
  std::vector<int> coarsen;             ///< cells of the forest whose children go, ascending
  AdaptLimit limit = AdaptLimit::none;  ///< with a tolerance that is missed: dofs before depth
  bool empty() const { return refine.empty() && coarsen.empty(); }
};

/// Von Mises stress of each cell at its centre [Pa].
Eigen::VectorXd cell_von_mises(const Discretization& d, const Eigen::Matrix3Xd& u);

/// Marks for one frame, none where the frame is not to be marked. Without a tolerance the rate of a cell is the change
/// of its von Mises stress since the last marking: the sign of the paper's dσ/dt > 0, read as a scalar. A cell without
/// a last stress (in the first frame) has no rate and is neither refined nor coarsened. Only `history.von_mises` is
/// updated.
///
/// No cell is both refined and in a family that is coarsened: the one asks for a rising stress, the other for none, and
/// with a tolerance families with a marked cell stay.
///
/// mesh: the forest's leaf mesh; von_mises: per cell [Pa]; dofs: of the mesh (Discretization::dof_count).
/// Errors are compared as squares, a tie to 2^-40 in favour of the mark, so that units scaled by a power of two, where
/// η scales by its root, change no decision that the solution does not leave to round-off.
/// Throws std::invalid_argument on rules out of range and on an η or a stress that is negative or not finite.
FrameMarks mark_frame(const RefinementForest& forest, const Mesh& mesh, const ErrorEstimate& estimate,
                      const Eigen::VectorXd& von_mises, int frame, int dofs, const FrameAdaptRules& rules,
                      FrameAdaptHistory& history);

struct FrameChange {
  int refined = 0;    ///< leaves that were replaced by their children
  int coarsened = 0;  ///< families that were replaced by their parent
};
/// Applies the marks to the forest, coarsening first, so that the storage is used again; the history follows.
///
/// New cells take their parent's stress as the last one. A cell that was coarsened to takes the mean of its children's.
/// The alternative, no stress until the next frame, would leave the cell without a rate for a frame, and the error of
/// a family that is coarsened is small, so its stresses lie close together. What the mean is off is on the quiet side:
/// von Mises stress is convex, its mean at least the stress of the mean, and the cell seems to relax rather than rise.
FrameChange adapt_forest(const Mesh& mesh, const FrameMarks& marks, int frame, RefinementForest& forest,
                         FrameAdaptHistory& history);

}  // namespace finegauge
