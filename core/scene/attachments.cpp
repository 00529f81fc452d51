#include "core/scene/attachments.hpp"

namespace finegauge {

bool held_by_springs(const SceneAttachment& attachment) { return attachment.stiffness > 0.0; }

Selected select(const BaseMesh& mesh, const SceneAttachment& attachment) {
  if (!held_by_springs(attachment)) return select_nodes(mesh, attachment.where);
  return select_facets(surface_facets(mesh), attachment.where);
}

std::vector<SurfacePoint> spring_places(const BaseMesh& mesh, const SceneAttachment& attachment) {
  if (!held_by_springs(attachment)) return {};
  const std::vector<SurfaceFacet> facets = surface_facets(mesh);
  return surface_points(mesh, facets, select_facets(facets, attachment.where).numbers);
}

void add_regions(const std::vector<SceneAttachment>& attachments, BaseMesh& mesh) {
  for (const SceneAttachment& attachment : attachments)
    if (!held_by_springs(attachment)) mesh.regions[attachment.name] = select_nodes(mesh, attachment.where).numbers;
}

}  // namespace finegauge
