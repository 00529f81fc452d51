#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/adapt/frame_adaptivity.hpp"

namespace finegauge {

/// Marking where a tolerance is asked for: which cells to refine so that it is met, and which families may go without
/// that it is missed. Sums of squares η_e² [J] are compared with squares of tolerances times the energy ∫ ε:σ.
///
/// What a change will do is predicted from the leading error of a smooth solution, which along an axis falls in
/// proportion to the cell's length along it (the share of the axis is ErrorEstimate::direction):
///   a cell divided n_i times along axis i keeps    η_e² Σ share_i / n_i²,
///   a family's parent has                          Σ_children η_e² Σ share_i n_i².
/// Where the solution is not smooth (under a needle's tip) refinement gains less and coarsening loses less than that:
/// a refinement that was not enough is seen in the next frame, and a coarsening is on the safe side.

/// η_e² after a division, of which η_e² is now.
double refined_error(double eta_squared, const Eigen::Vector3d& direction, RefinementTemplate refinement);
/// Share of a cell in its parent's η² where the parent has this template.
double coarsened_error(double eta_squared, const Eigen::Vector3d& direction, RefinementTemplate refinement);

/// Levels of the global η² [J] between which nothing happens.
struct ToleranceLevels {
  double refine_above = 0.0;   ///< refine when Σ η_e² is above
  double refine_to = 0.0;      ///< as many cells as bring it to this
  double coarsen_up_to = 0.0;  ///< coarsen as long as it stays at or below
  bool reachable = true;       ///< the refinement of all candidates is predicted to meet the tolerance
};

/// Cells that would be refined if their error asked for it, with what their refinement is predicted to gain.
struct RefinementCandidate {
  Refinement refinement;
  double gain;  ///< [J]
};
/// All cells with an error that depth and lattice allow to refine, ascending.
std::vector<RefinementCandidate> refinement_candidates(const RefinementForest& forest, const Mesh& mesh,
                                                       const ErrorEstimate& estimate, const FrameAdaptRules& rules);

/// The levels of the global tolerance. Where the depth limit leaves so large an error in some cells that the refinement
/// of all others would not meet the tolerance, what would be left takes the tolerance's place: the more it is missed,
/// the more of the cells that would hardly lower Σ η_e² are left alone (up to a sixth of it), instead of dividing the
/// whole body for nothing, and cells without weight may go.
ToleranceLevels tolerance_levels(const ErrorEstimate& estimate, std::span<const RefinementCandidate> candidates,
                                 const FrameAdaptRules& rules);

/// The fewest candidates that bring Σ η_e² to the level (bulk criterion, Dörfler 1996, on the gains), whatever their
/// stress does; with a local tolerance, those of which η_e is more than its share of it, too. Ascending.
std::vector<Refinement> refine_to_tolerance(const ErrorEstimate& estimate, const ToleranceLevels& levels,
                                            std::span<const RefinementCandidate> candidates,
                                            const FrameAdaptRules& rules);

/// Whether a cell that misses the local tolerance is as deep as it may be.
bool local_tolerance_is_out_of_reach(const ErrorEstimate& estimate, std::span<const RefinementCandidate> candidates,
                                     const FrameAdaptRules& rules);

/// Families that may go, those that add least to Σ η_e² first; no child is marked for refinement (per cell, 1) or
/// younger than the dwell time. Cells of the forest, ascending.
std::vector<int> coarsen_within_tolerance(const RefinementForest& forest, const Mesh& mesh,
                                          const ErrorEstimate& estimate, const ToleranceLevels& levels,
                                          std::span<const std::uint8_t> marked, int frame, const FrameAdaptRules& rules,
                                          const FrameAdaptHistory& history);

}  // namespace finegauge
