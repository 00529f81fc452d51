#pragma once

#include "core/mesh/refinement_forest.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// The base mesh with the scene's initial refinements.
RefinementForest start_forest(const Scene& scene);

}  // namespace finegauge
