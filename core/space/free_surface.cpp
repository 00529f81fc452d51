#include "core/space/free_surface.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <set>

namespace finegauge {

namespace {

/// Base faces of surfaces that are named.
template <class Named>
std::set<BaseFace> faces_of(const BaseMesh& base, const std::vector<Named>& conditions) {
  std::set<BaseFace> faces;
  for (const Named& condition : conditions)
    if (const auto surface = base.surfaces.find(condition.surface); surface != base.surfaces.end())
      faces.insert(surface->second.begin(), surface->second.end());
  return faces;
}

std::array<int, 3> nodes_of(const Mesh& mesh, const BoundaryFace& face) {
  const auto& corners = face_corners(mesh.shape, face.face);
  const auto& cell = mesh.cells[face.cell];
  return {cell[corners[0]], cell[corners[1]], cell[corners[2]]};
}

Eigen::Vector3d area_vector(const std::array<int, 3>& face, const Eigen::Matrix3Xd& x) {
  const Eigen::Vector3d a = x.col(face[1]) - x.col(face[0]), b = x.col(face[2]) - x.col(face[0]);
  return 0.5 * a.cross(b);
}

}  // namespace

FreeSurface find_free_surface(const RefinementForest& forest, const Discretization& d,
                              const std::vector<SupportCondition>& supports, const std::vector<SurfaceLoad>& loads) {
  const BaseMesh& base = forest.base();
  const Mesh& mesh = d.mesh;
  FreeSurface surface;
  if (mesh.shape != CellShape::tetrahedron || base.body || !d.springs.empty()) return surface;

  const std::set<BaseFace> held = faces_of(base, supports), loaded = faces_of(base, loads);
  std::vector<std::vector<std::array<int, 3>>> around(static_cast<std::size_t>(mesh.node_count()));
  std::vector<std::uint8_t> unknown =
      nodes_on_singular_edges(base, forest.topology(), mesh, supports, d.shapes.material().poisson_ratio);
  for (const BoundaryFace& face : mesh.boundary) {
    const std::array<int, 3> nodes = nodes_of(mesh, face);
    for (const int node : nodes) {
      if (loaded.contains(face.base))
        unknown[node] = 1;
      else if (!held.contains(face.base))
        around[node].push_back(nodes);
    }
  }
  for (std::size_t s = 0; s < d.supports.reduced.size(); ++s) {
    const int node = d.hanging.node_of[d.supports.reduced[s]];
    for (const std::array<int, 3>& face : around[node]) {
      const Eigen::Vector3d n = area_vector(face, mesh.nodes).normalized();
      if (n.dot(d.supports.held[s] * n) > 1e-9) unknown[node] = 1;
    }
  }
  surface.face_start.push_back(0);
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (around[node].empty() || unknown[node] || d.hanging.hangs(node)) continue;
    surface.nodes.push_back(node);
    surface.faces.insert(surface.faces.end(), around[node].begin(), around[node].end());
    surface.face_start.push_back(static_cast<int>(surface.faces.size()));
  }
  return surface;
}

Eigen::Matrix3d free_directions(const FreeSurface& surface, std::size_t k, const Eigen::Matrix3Xd& x) {
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  for (int face = surface.face_start[k]; face < surface.face_start[k + 1]; ++face) {
    const Eigen::Vector3d area = area_vector(surface.faces[face], x);
    const double size = area.norm();
    if (size > 0.0) normals += area * (area / size).transpose();
  }
  // Two faces at an angle φ between their normals have the shares (1 ± cos φ) / 2.
  constexpr double least_share = 0.1;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(normals);
  const double least = least_share * normals.trace();
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i)
    if (axes.eigenvalues()[i] <= least) P += axes.eigenvectors().col(i) * axes.eigenvectors().col(i).transpose();
  return P;
}

}  // namespace finegauge
