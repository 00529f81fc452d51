#pragma once

#include <vector>

#include "core/adapt/error_estimate.hpp"
#include "core/adapt/marking.hpp"
#include "core/mesh/mesh.hpp"

namespace finegauge {

struct DirectionalMarking {
  double theta = 0.35;     ///< share of the largest directional error from which an axis is divided, 0 < theta <= 1
  int division = 2;        ///< parts that a marked axis is divided into: 2, or 3
  bool may_repeat = true;  ///< divide twice at once (4 for 2) where one division would leave the axis marked
};

/// The template of each cell by the direction of its error: the maximum strategy, asked of every cell and axis apart.
///
/// The error of cell e along axis i is η_{e,i} = η_e sqrt(share_i). An axis with η_{e,i} >= θ max η is divided, all
/// others are kept, so that the template is the cheapest that meets the error where it is (2×1×1 to 4×4×4). Since the
/// leading error along an axis falls in proportion to the cell's length, one division leaves η_{e,i} / 2, and an axis
/// with η_{e,i} >= 2 θ max η is divided twice at once.
///
/// Halves and thirds are not mixed: on a face that is halved on one side and cut in three on the other, a conforming
/// field can bend at neither (hanging_nodes.hpp), and where they meet everywhere the mesh gets worse by refinement.
/// `division` is therefore one choice for a whole mesh.
///
/// Cells of `mesh` are ascending; a cell of depth max_depth is left alone. Tetrahedra have no axes: they get their one
/// template by mark_maximum.
std::vector<Refinement> choose_templates(const Mesh& mesh, const ErrorEstimate& estimate,
                                         const DirectionalMarking& marking, int max_depth);

}  // namespace finegauge
