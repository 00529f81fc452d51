#pragma once

#include <vector>

#include "verification/support/atlas.hpp"

namespace finegauge {

/// Backward Euler: time step, density, damping, and the pairs of them; a free body; decay to nothing.
std::vector<AtlasAxis> dynamics_axes();

}  // namespace finegauge
