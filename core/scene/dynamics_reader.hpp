#pragma once

#include "core/scene/scene.hpp"
#include "core/scene/scene_document.hpp"
#include "core/scene/section_reader.hpp"

namespace finegauge {

/// Reads what makes a scene move: [dynamics], and [solver] and [adapt] as a moving scene has them. Call it after the
/// needle was read, whose strokes are the duration where the scene gives none.
void read_dynamics(const SceneDocument& document, CellShape shape, Scene& scene);

}  // namespace finegauge
