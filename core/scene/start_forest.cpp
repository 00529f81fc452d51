#include "core/scene/start_forest.hpp"

#include "core/adapt/apply_refinements.hpp"
#include "core/elasticity/cell_geometry.hpp"

namespace finegauge {

RefinementForest start_forest(const Scene& scene) {
  RefinementForest forest(base_mesh(scene));
  for (const InitialRefinement& region : scene.refinements)
    for (int level = 0; level < region.levels; ++level) {
      const Mesh mesh = forest.leaf_mesh();
      const int corners = corner_count(mesh.shape);
      std::vector<Refinement> chosen;
      for (int e = 0; e < mesh.cell_count(); ++e) {
        const Eigen::Vector3d centre = corner_values(mesh, e, mesh.nodes).leftCols(corners).rowwise().mean();
        const bool within =
            (centre.array() >= region.min.array()).all() && (centre.array() <= region.max.array()).all();
        if (within) chosen.push_back({e, region.refinement});
      }
      apply_refinements(forest, mesh, chosen);
    }
  return forest;
}

}  // namespace finegauge
