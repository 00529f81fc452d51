#pragma once

#include "core/scene/scene.hpp"
#include "core/scene/scene_document.hpp"

namespace finegauge {

/// Refuses [needle], [[stroke]] and [contact] without one another or without [dynamics]. To be asked where the scene
/// has one of them.
void check_needle_sections(const SceneDocument& document);

/// Reads [needle], [[stroke]] and [contact], and checks that the needle starts outside the body at rest and that its
/// base never enters it. The scene must have [needle].
void read_needle(const SceneDocument& document, const BaseMesh& mesh, Scene& scene);

}  // namespace finegauge
