#pragma once

#include <string>

#include "core/mesh/refinement_forest.hpp"
#include "core/space/loads.hpp"
#include "core/space/supports.hpp"

namespace finegauge {

/// Where in a cube cells are refined.
enum class MarkingPattern {
  block,     ///< nearest to the cube's centre, by the largest coordinate: a smaller cube
  needle,    ///< nearest to a line that enters the middle of x = 0 and ends at x = 0.6
  scattered  ///< drawn at random
};
std::string to_string(MarkingPattern pattern);
inline constexpr MarkingPattern marking_patterns[] = {MarkingPattern::block, MarkingPattern::needle,
                                                      MarkingPattern::scattered};

/// A cube of edge 1 whose face x = 1 is held and whose face x = 0 is pulled and sheared.
struct MarkedCube {
  int cells_per_edge = 4;
  MarkingPattern pattern = MarkingPattern::block;
  double share = 0.1;  ///< of the cells, in (0, 1]: refined, rounded to whole cells and at least one
  RefinementTemplate refinement = {};
  int levels = 1;     ///< with more the same share of the smallest cells is refined again, by the same pattern
  unsigned seed = 1;  ///< of `scattered`
};
RefinementForest refined_forest(const MarkedCube& cube);
std::vector<SupportCondition> cube_supports();
std::vector<SurfaceLoad> cube_loads();

}  // namespace finegauge
