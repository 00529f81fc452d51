#include "core/adapt/tolerance_marking.hpp"

#include <algorithm>
#include <limits>

#include "core/adapt/marking_comparison.hpp"

namespace finegauge {
namespace {

/// Where the tolerance is out of reach, Σ η_e² may stay above what the refinement of all candidates would leave by as
/// much as that is above the tolerance, and by this share of it at most: a fifth of η² is 10 % of η, less than the
/// estimate itself knows. At the edge of reach there is no slack, and so no jump in the number of cells either.
constexpr double most_slack = 0.2;
/// The part of the slack that coarsening may use; the rest keeps cells from coming and going.
constexpr double coarsen_slack = 0.25;
/// The least gap to the level from which on cells are refined, as a share of it.
constexpr double coarsen_below_refine = 0.9;
/// What a family of cells that are filled in part may lose by a coarsening, in squares, over the prediction for a
/// smooth solution: each child has its own piece of the surface, with what holds and loads it; in the parent these are
/// one. Measured on livers: in the middle parents have 0.7 of the η_e predicted, but in cells of 30 mm those that had
/// to be refined again in the next frame had 1.4 to 3.9 times it, 2.4 in the middle. Used for the worst cell, where
/// nothing averages: without it such a family goes and comes for ever (in the sixty frames of the test of
/// liver_local.toml 44 changes of the mesh are taken back, with 4 seven, with 6 none).
constexpr double cut_family_loss = 6.0;
/// Cells whose gains differ by less than this share stand or fall together: those that lie symmetrically differ by what
/// the solver leaves, and a body and its load that are symmetric shall not get a mesh that is not.
constexpr double symmetric = 1e-3;

/// The rule's template, or the one that divides the axes along which the cell's error lies: those with at least θ_r of
/// the largest of its own. In halves, or in thirds where the rule's template has one, as in directional_marking.hpp.
RefinementTemplate template_of(const Eigen::Vector3d& direction, CellShape shape, const FrameAdaptRules& rules) {
  if (!rules.directional || shape == CellShape::tetrahedron)
    return shape == CellShape::tetrahedron ? RefinementTemplate{} : rules.refinement;
  const auto& divisions = rules.refinement.divisions;
  const std::uint8_t division = std::count(divisions.begin(), divisions.end(), 3) > 0 ? 3 : 2;
  RefinementTemplate refinement{{1, 1, 1}};
  for (int axis = 0; axis < 3; ++axis)
    if (at_least(direction[axis], square(rules.refine_above) * direction.maxCoeff()))
      refinement.divisions[axis] = division;
  return refinement;
}

}  // namespace

double refined_error(double eta_squared, const Eigen::Vector3d& direction, RefinementTemplate refinement) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) sum += direction[axis] / square(refinement.divisions[axis]);
  return eta_squared * sum;
}

double coarsened_error(double eta_squared, const Eigen::Vector3d& direction, RefinementTemplate refinement) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) sum += direction[axis] * square(refinement.divisions[axis]);
  return eta_squared * sum;
}

std::vector<RefinementCandidate> refinement_candidates(const RefinementForest& forest, const Mesh& mesh,
                                                       const ErrorEstimate& estimate, const FrameAdaptRules& rules) {
  std::vector<RefinementCandidate> candidates;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    if (!(estimate.eta[cell] > 0.0)) continue;
    const Eigen::Vector3d direction = estimate.direction.col(cell);
    const RefinementTemplate refinement = template_of(direction, mesh.shape, rules);
    const int levels = divides_by_four(refinement) ? 2 : 1;
    if (mesh.frames[cell].depth + levels > rules.max_depth) continue;
    if (!forest.can_refine(mesh.forest_cell[cell], refinement)) continue;
    const double error = square(estimate.eta[cell]);
    candidates.push_back({{cell, refinement}, error - refined_error(error, direction, refinement)});
  }
  return candidates;
}

ToleranceLevels tolerance_levels(const ErrorEstimate& estimate, std::span<const RefinementCandidate> candidates,
                                 const FrameAdaptRules& rules) {
  ToleranceLevels levels;
  if (!(rules.tolerance > 0.0)) {  // not asked: any error will do
    levels.refine_above = levels.refine_to = levels.coarsen_up_to = std::numeric_limits<double>::infinity();
    return levels;
  }
  const double allowed = square(rules.tolerance * estimate.energy_norm);
  double left = square(estimate.total);
  for (const RefinementCandidate& candidate : candidates) left -= candidate.gain;
  left = std::max(left, 0.0);
  levels.reachable = at_most(left, allowed);
  if (levels.reachable) {
    const double reach = std::min((1.0 + most_slack) * left, allowed);
    levels.refine_above = std::max(square(rules.refine_at) * allowed, reach);
    levels.refine_to = std::max(square(0.5 * (rules.refine_at + rules.coarsen_at)) * allowed, reach);
    levels.coarsen_up_to =
        std::max(square(rules.coarsen_at) * allowed,
                 std::min((1.0 + coarsen_slack * most_slack) * left, coarsen_below_refine * levels.refine_above));
    return levels;
  }
  const double slack = std::min(most_slack * left, left - allowed);
  levels.refine_above = levels.refine_to = left + slack;
  levels.coarsen_up_to = left + coarsen_slack * slack;
  return levels;
}

std::vector<Refinement> refine_to_tolerance(const ErrorEstimate& estimate, const ToleranceLevels& levels,
                                            std::span<const RefinementCandidate> candidates,
                                            const FrameAdaptRules& rules) {
  std::vector<std::uint8_t> wanted(candidates.size(), 0);
  if (const double error = square(estimate.total); !at_most(error, levels.refine_above)) {
    std::vector<int> order(candidates.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return candidates[a].gain > candidates[b].gain; });
    double left = error, last = 0.0;
    for (const int i : order) {
      // `last`: the first of those that stand together.
      if (at_most(left, levels.refine_to) && candidates[i].gain < (1.0 - symmetric) * last) break;
      if (!at_most(left, levels.refine_to)) last = candidates[i].gain;
      left -= candidates[i].gain;
      wanted[i] = 1;
    }
  }
  if (rules.local_tolerance > 0.0) {
    const double allowed = square(rules.refine_at * rules.local_tolerance * estimate.energy_norm);
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (!at_most(square(estimate.eta[candidates[i].refinement.cell]), allowed)) wanted[i] = 1;
  }
  std::vector<Refinement> refine;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (wanted[i]) refine.push_back(candidates[i].refinement);
  return refine;
}

bool local_tolerance_is_out_of_reach(const ErrorEstimate& estimate, std::span<const RefinementCandidate> candidates,
                                     const FrameAdaptRules& rules) {
  if (!(rules.local_tolerance > 0.0)) return false;
  const double allowed = square(rules.local_tolerance * estimate.energy_norm);
  const auto misses = [&](int cell) { return !at_most(square(estimate.eta[cell]), allowed); };
  int missing = 0;
  for (int cell = 0; cell < static_cast<int>(estimate.eta.size()); ++cell) missing += misses(cell);
  for (const RefinementCandidate& candidate : candidates) missing -= misses(candidate.refinement.cell);
  return missing > 0;
}

std::vector<int> coarsen_within_tolerance(const RefinementForest& forest, const Mesh& mesh,
                                          const ErrorEstimate& estimate, const ToleranceLevels& levels,
                                          std::span<const std::uint8_t> marked, int frame, const FrameAdaptRules& rules,
                                          const FrameAdaptHistory& history) {
  struct Family {
    int parent;
    double added;  // to Σ η_e² [J]
  };
  std::vector<Family> families;
  const double local = rules.local_tolerance > 0.0
                           ? square(rules.coarsen_at * rules.local_tolerance * estimate.energy_norm)
                           : std::numeric_limits<double>::infinity();
  visit_families(forest, mesh, [&](int parent, int first, int count) {
    double now = 0.0, then = 0.0;
    bool cut = false;
    for (int cell = first; cell < first + count; ++cell) {
      cut = cut || material_share(mesh, cell) < 1.0;
      if (marked[cell] || frame - history.changed[mesh.forest_cell[cell]] < rules.dwell) return;
      const double error = square(estimate.eta[cell]);
      now += error;
      then += coarsened_error(error, estimate.direction.col(cell), forest.cell(parent).refinement);
    }
    if (at_most(cut ? cut_family_loss * then : then, local)) families.push_back({parent, then - now});
  });
  std::stable_sort(families.begin(), families.end(),
                   [](const Family& a, const Family& b) { return a.added < b.added; });
  double error = square(estimate.total);
  std::size_t taken = 0;
  while (taken < families.size() && at_most(error + families[taken].added, levels.coarsen_up_to))
    error += families[taken++].added;
  if (taken < families.size())  // the first that stays, and those that stand with it
    while (taken > 0 && families[taken - 1].added >= (1.0 - symmetric) * families[taken].added) --taken;
  std::vector<int> coarsen;
  for (std::size_t i = 0; i < taken; ++i) coarsen.push_back(families[i].parent);
  std::sort(coarsen.begin(), coarsen.end());
  return coarsen;
}

}  // namespace finegauge
