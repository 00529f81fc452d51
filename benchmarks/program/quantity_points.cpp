#include "benchmarks/program/quantity_points.hpp"

#include "core/scene/scene_error.hpp"

namespace finegauge {

std::vector<std::optional<MaterialPoint>> quantity_points(const Scene& scene, const BaseMesh& base) {
  std::vector<std::optional<MaterialPoint>> points;
  for (const QuantityOfInterest& quantity : scene.quantities) {
    points.emplace_back();
    if (quantity.kind != QuantityKind::displacement) continue;
    points.back() = locate_at_rest(base, quantity.point);
    if (!points.back())  // the reader of scenes has refused it with its line
      throw SceneError(scene.file + ": quantity.point of \"" + quantity.name + "\": allowed are points of the body");
  }
  return points;
}

}  // namespace finegauge
