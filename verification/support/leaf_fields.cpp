#include "verification/support/leaf_fields.hpp"

#include <algorithm>
#include <cmath>

#include "verification/support/refinement_history.hpp"

namespace finegauge {

BaseMesh box_of_cubes(std::array<int, 3> cells, CellShape shape) {
  BoxMeshOptions options;
  options.cells = cells;
  options.size = Eigen::Vector3d(cells[0], cells[1], cells[2]);
  options.shape = shape;
  return box_mesh(options);
}

LeafFields leaf_fields(const Mesh& mesh, double energy, const std::function<LeafField(int)>& leaf, double energy_scale,
                       double stress_scale) {
  LeafFields f;
  f.estimate.eta.resize(mesh.cell_count());
  f.estimate.direction.resize(3, mesh.cell_count());
  f.von_mises.resize(mesh.cell_count());
  double total = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const LeafField field = leaf(cell);
    f.estimate.eta[cell] = std::sqrt(energy_scale * field.eta_squared);
    f.estimate.direction.col(cell) = field.direction;
    f.von_mises[cell] = stress_scale * field.von_mises;
    total += energy_scale * field.eta_squared;
  }
  f.estimate.total = std::sqrt(total);
  f.estimate.energy_norm = std::sqrt(energy_scale * energy);
  f.estimate.relative = energy > 0.0 ? f.estimate.total / f.estimate.energy_norm : 0.0;
  return f;
}

Eigen::Vector3d cell_centre(const Mesh& mesh, int cell) {
  const int corners = corner_count(mesh.shape);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int c = 0; c < corners; ++c) sum += mesh.nodes.col(mesh.cells[cell][c]);
  return sum / corners;
}

Eigen::Vector3d cell_size(const Mesh& mesh, int cell) {
  return mesh.nodes.col(mesh.cells[cell][7]) - mesh.nodes.col(mesh.cells[cell][0]);
}

bool history_follows(const FrameAdaptHistory& history, const RefinementForest& forest) {
  const auto handles = static_cast<std::size_t>(forest.handle_count());
  if (history.von_mises.size() != handles || history.changed.size() != handles || history.coarsened.size() != handles)
    return false;
  std::vector<std::uint8_t> leaf(handles, 0);
  for (const int handle : leaves(forest)) leaf[handle] = 1;
  for (std::size_t handle = 0; handle < handles; ++handle)
    if (!leaf[handle] && (history.von_mises[handle] >= 0.0 || history.coarsened[handle] ||
                          history.changed[handle] != FrameAdaptHistory::long_ago))
      return false;
  return true;
}

bool same_marks(const FrameMarks& a, const FrameMarks& b) {
  return a.coarsen == b.coarsen &&
         std::equal(a.refine.begin(), a.refine.end(), b.refine.begin(), b.refine.end(),
                    [](const auto& p, const auto& q) { return p.cell == q.cell && p.refinement == q.refinement; });
}

FrameMarks marks_after_one_frame(const RefinementForest& forest, const LeafFields& f, const FrameAdaptRules& rules,
                                 int dofs) {
  FrameAdaptHistory history;
  const Mesh mesh = forest.leaf_mesh();
  LeafFields before = f;
  before.von_mises.setOnes();
  static_cast<void>(mark_frame(forest, mesh, before.estimate, before.von_mises, 0, dofs, rules, history));
  return mark_frame(forest, mesh, f.estimate, f.von_mises, rules.every, dofs, rules, history);
}

}  // namespace finegauge
