#pragma once

#include <string>
#include <vector>

#include "core/mesh/surface_selection.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// Whether springs hold the attachment; else its region is clamped.
bool held_by_springs(const SceneAttachment& attachment);

/// What an attachment selects: base nodes when it is clamped, facets of the surface when springs hold it.
Selected select(const BaseMesh& mesh, const SceneAttachment& attachment);

/// Where an attachment's springs are, with their share of its area; none for a clamped one. `mesh` is the scene's.
std::vector<SurfacePoint> spring_places(const BaseMesh& mesh, const SceneAttachment& attachment);

/// Adds the regions of the clamped attachments.
void add_regions(const std::vector<SceneAttachment>& attachments, BaseMesh& mesh);

}  // namespace finegauge
