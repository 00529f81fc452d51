#pragma once

#include <vector>

#include "verification/support/atlas.hpp"

namespace finegauge {

/// What the tissue is made of, and in which units: Poisson's ratio towards both of its ends, Young's modulus, the size
/// of the load down to none at all.
std::vector<AtlasAxis> material_axes();

}  // namespace finegauge
