#pragma once

#include "core/scene/scene.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Throws SceneError, naming the scene's supports, when they, its attachments and the springs of these leave a body of
/// the mesh a rigid motion: a part whose cells hang together through faces (supports.hpp, free_rigid_motions). A static
/// scene is refused then: its equilibrium does not exist or is not unique. `topology` is that of the forest that the
/// discretization was made from.
void check_held(const Scene& scene, const BaseTopology& topology, const Discretization& discretization);

}  // namespace finegauge
