#pragma once

#include "core/scene/scene.hpp"
#include "core/scene/scene_document.hpp"
#include "core/scene/section_reader.hpp"

namespace finegauge {

/// Reads what makes a scene move: [dynamics], and [solver] and [adapt] as a moving scene has them. Call it after the
/// needle was read, whose strokes are the duration where the scene gives none.
void read_dynamics(const SceneDocument& document, CellShape shape, Scene& scene);

/// The keys course and period of a [[support]]; none without a course.
std::optional<Course> read_course(const SectionReader& reader);

}  // namespace finegauge
