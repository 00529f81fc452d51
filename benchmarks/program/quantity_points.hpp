#pragma once

#include <optional>
#include <vector>

#include "core/mesh/point_location.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// The material points of the scene's quantities, one per quantity; none for a quantity without a point. Throws
/// SceneError for a point that is not in the body.
std::vector<std::optional<MaterialPoint>> quantity_points(const Scene& scene, const BaseMesh& base);

}  // namespace finegauge
