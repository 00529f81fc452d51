#include "core/scene/check_held.hpp"

#include <string>

#include "core/scene/scene_error.hpp"

namespace finegauge {

void check_held(const Scene& scene, const Discretization& discretization) {
  const int free_motions = free_rigid_motions(discretization.mesh, discretization.hanging, discretization.supports);
  if (free_motions == 0) return;
  throw SceneError(scene.file + ":" + std::to_string(scene.support_line) + ": support: the body is not held, found " +
                   std::to_string(scene.supports.size()) + " supports that leave " + std::to_string(free_motions) +
                   " of its six rigid motions free, allowed 0");
}

}  // namespace finegauge
