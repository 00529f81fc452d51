#pragma once

#include <vector>

#include "verification/support/atlas.hpp"

namespace finegauge {

/// Corotational cells: rotations at and beside half a turn, from a cell at rest and from one that is nearly there;
/// cells that were flattened, inverted or squeezed to needles, and let go.
std::vector<AtlasAxis> kinematics_axes();

}  // namespace finegauge
