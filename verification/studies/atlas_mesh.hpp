#pragma once

#include <vector>

#include "verification/support/atlas.hpp"

namespace finegauge {

/// The mesh: slender cells, refinement that goes deep beside cells that are not refined, cells that are hardly filled;
/// and depth with a tissue that hardly changes its volume.
std::vector<AtlasAxis> mesh_axes();

}  // namespace finegauge
