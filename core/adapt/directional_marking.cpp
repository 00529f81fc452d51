#include "core/adapt/directional_marking.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>

namespace finegauge {

std::vector<Refinement> choose_templates(const Mesh& mesh, const ErrorEstimate& estimate,
                                         const DirectionalMarking& marking, int max_depth) {
  if (!(marking.theta > 0.0 && marking.theta <= 1.0))
    throw std::invalid_argument("theta: found " + std::to_string(marking.theta) + ", allowed is 0 < theta <= 1");
  if (marking.division != 2 && marking.division != 3)
    throw std::invalid_argument("division: found " + std::to_string(marking.division) + ", allowed are 2 and 3");
  std::vector<Refinement> chosen;
  if (mesh.shape == CellShape::tetrahedron) {
    for (const int cell : mark_maximum(std::span(estimate.eta.data(), estimate.eta.size()), marking.theta))
      if (mesh.frames[cell].depth < max_depth) chosen.push_back({cell, {}});
    return chosen;
  }
  const auto along = [&](int cell, int axis) { return estimate.eta[cell] * std::sqrt(estimate.direction(axis, cell)); };
  if (!estimate.eta.allFinite() || !estimate.direction.allFinite())
    throw std::invalid_argument("eta: found a value that is not finite");
  double largest = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, along(cell, axis));
  if (!(largest > 0.0)) return chosen;
  const bool can_repeat = marking.may_repeat && marking.division * marking.division <= max_divisions;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    if (mesh.frames[cell].depth >= max_depth) continue;
    // Two divisions at once are two levels (apply_refinements.hpp).
    const bool may_repeat = can_repeat && mesh.frames[cell].depth + 2 <= max_depth;
    RefinementTemplate refinement{{1, 1, 1}};
    for (int axis = 0; axis < 3; ++axis) {
      const double share = along(cell, axis) / largest;
      const int divisions = share < marking.theta ? 1
                            : may_repeat && share >= marking.division * marking.theta
                                ? marking.division * marking.division
                                : marking.division;
      refinement.divisions[axis] = static_cast<std::uint8_t>(divisions);
    }
    if (refinement.child_count() > 1) chosen.push_back({cell, refinement});
  }
  return chosen;
}

}  // namespace finegauge
