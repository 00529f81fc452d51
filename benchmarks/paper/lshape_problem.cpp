#include "benchmarks/paper/lshape_problem.hpp"

#include <stdexcept>
#include <utility>

namespace finegauge {

namespace {

BaseMesh lshape_mesh(int cells_per_edge, NotchCorner notch) {
  if (!(cells_per_edge > 0 && cells_per_edge % 2 == 0))
    throw std::invalid_argument("cells_per_edge is " + std::to_string(cells_per_edge) +
                                ", but must be even and positive");
  const int n = cells_per_edge, half = n / 2;
  const bool right = notch == NotchCorner::lower_right || notch == NotchCorner::upper_right;
  const bool upper = notch == NotchCorner::upper_left || notch == NotchCorner::upper_right;
  const int x = right ? half : 0, y = upper ? half : 0;
  BoxMeshOptions box;
  box.size = {4.0, 4.0, 2.0};
  box.cells = {n, n, half};
  box.removed = RemovedBlock{{x, y, 0}, {x + half, y + half, half}};
  return box_mesh(box);
}

void require_surface(const BaseMesh& mesh, const std::string& name, const char* use) {
  if (mesh.surfaces.count(name) != 0) return;
  std::string known;
  for (const auto& [other, faces] : mesh.surfaces) known += (known.empty() ? "" : ", ") + other;
  throw std::invalid_argument(std::string(use) + " surface is '" + name + "', but must be one of " + known);
}

Eigen::Vector3d normal_of_box_surface(const std::string& name) {
  const auto axis = std::string("xyz").find(name.front());
  if (axis == std::string::npos)
    throw std::invalid_argument("roller surface is '" + name + "', but must be a plane of the box");
  return Eigen::Vector3d::Unit(static_cast<int>(axis));
}

}  // namespace

LshapeProblem lshape_problem(const LshapeOptions& options) {
  BaseMesh mesh = lshape_mesh(options.cells_per_edge, options.notch);
  require_surface(mesh, options.clamped, "clamped");
  require_surface(mesh, options.loaded, "loaded");
  std::vector<SupportCondition> supports;
  supports.push_back({options.clamped, std::nullopt, {}});
  if (!options.roller.empty()) {
    require_surface(mesh, options.roller, "roller");
    supports.push_back({options.roller, normal_of_box_surface(options.roller), {}});
  }
  std::vector<SurfaceLoad> loads = {{options.loaded, LoadKind::traction, options.traction}};
  return {RefinementForest(std::move(mesh)), options.material, std::move(supports), std::move(loads)};
}

}  // namespace finegauge
