#include "core/scene/check_held.hpp"

#include <algorithm>
#include <sstream>
#include <string>

#include "core/scene/scene_error.hpp"

namespace finegauge {

void check_held(const Scene& scene, const BaseTopology& topology, const Discretization& discretization) {
  const std::vector<BodyFreedom> bodies = free_rigid_motions(topology, discretization.mesh, discretization.hanging,
                                                             discretization.supports, discretization.springs);
  const auto loose = std::ranges::find_if(bodies, [](const BodyFreedom& body) { return body.free_motions > 0; });
  if (loose == bodies.end()) return;
  std::ostringstream message;
  message.precision(6);
  message << scene.file << ":" << scene.support_line << ": support: the body";
  if (bodies.size() > 1)
    message << " of " << loose->cells << (loose->cells == 1 ? " cell" : " cells") << " around (" << loose->inside.x()
            << ", " << loose->inside.y() << ", " << loose->inside.z() << "), one of " << bodies.size()
            << " that share no face,";
  message << " is not held, found " << scene.supports.size() + scene.attachments.size() << " supports that leave "
          << loose->free_motions << " of its six rigid motions free, allowed 0";
  throw SceneError(message.str());
}

}  // namespace finegauge
