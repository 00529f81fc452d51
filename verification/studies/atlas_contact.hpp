#pragma once

#include <vector>

#include "verification/support/atlas.hpp"

namespace finegauge {

/// A needle in tissue: stiffness and mass beside the tissue's, the augmented Lagrangian's weight, friction, units, time
/// step; where the needle goes in the cells; and cells that are coarsened under it.
std::vector<AtlasAxis> contact_axes();

}  // namespace finegauge
