#pragma once

#include <span>
#include <vector>

#include "core/adapt/error_estimate.hpp"
#include "core/mesh/refinement_template.hpp"

namespace finegauge {

/// Cells to refine, ascending. Cells with eta = 0 are never marked.
std::vector<int> mark_maximum(std::span<const double> eta, double theta);   ///< eta_e >= theta max eta, 0 < theta <= 1
std::vector<int> mark_bulk(std::span<const double> eta, double theta);      ///< Dörfler 1996: smallest set with Σ eta² >= theta² Σ eta²
std::vector<int> mark_fraction(std::span<const double> eta, double share);  ///< the share of the cells with the largest eta, ties by cell
std::vector<int> mark_above(std::span<const double> eta, double threshold);  ///< eta_e > threshold

/// A cell and the template that it is to be refined by.
struct Refinement {
  int cell;
  RefinementTemplate refinement;
};

}  // namespace finegauge
