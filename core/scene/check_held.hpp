#pragma once

#include "core/scene/scene.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Throws SceneError, naming the scene's supports, when they leave the body a rigid motion. A static scene is refused
/// then: its equilibrium does not exist or is not unique.
void check_held(const Scene& scene, const Discretization& discretization);

}  // namespace finegauge
