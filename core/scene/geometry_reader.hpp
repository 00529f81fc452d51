#pragma once

#include "core/scene/scene.hpp"
#include "core/scene/scene_document.hpp"
#include "core/scene/section_reader.hpp"

namespace finegauge {

/// Reads the one of [box], [mesh], [gmsh] and [organ] that the scene has.
void read_geometry(const SceneDocument& document, Scene& scene);

/// Adds a [[surface]] to the scene; `mesh` is the base mesh with the surfaces known so far.
void read_named_surface(const SectionReader& reader, const BaseMesh& mesh, Scene& scene);

/// The key `template` of a section.
RefinementTemplate read_template(const SectionReader& reader, CellShape shape);

}  // namespace finegauge
