#include "core/space/free_surface.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <set>

#include "core/mesh/region.hpp"
#include "core/parallel/for_parts.hpp"

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

/// A face at one of its nodes: unit normal, none of a face without an area, and angle [rad].
struct FaceAtNode {
  Eigen::Vector3d normal;
  double angle;
};

FaceAtNode face_at(const std::array<int, 3>& face, int node, const Eigen::Matrix3Xd& x) {
  const int here = face[0] == node ? 0 : face[1] == node ? 1 : 2;
  const Eigen::Vector3d a = x.col(face[(here + 1) % 3]) - x.col(node), b = x.col(face[(here + 2) % 3]) - x.col(node);
  const Eigen::Vector3d across = a.cross(b);
  return {across.stableNormalized(), std::atan2(across.norm(), a.dot(b))};
}

Eigen::Matrix3d directions_at(const FreeSurface& surface, int k, const Eigen::Matrix3Xd& x) {
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  for (int face = surface.face_start[k]; face < surface.face_start[k + 1]; ++face) {
    const FaceAtNode there = face_at(surface.faces[face], surface.nodes[k], x);
    normals += there.angle * there.normal * there.normal.transpose();
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
      const Eigen::Vector3d n = face_at(face, node, mesh.nodes).normal;
      if (n.dot(d.supports.held[s] * n) > 1e-9) unknown[node] = 1;
    }
  }
  // What is held of a region may be held along its faces.
  for (const SupportCondition& condition : supports)
    if (const auto region = base.regions.find(condition.surface); region != base.regions.end())
      for (const int node : region_nodes(base, mesh, region->second)) unknown[node] = 1;
  surface.face_start.push_back(0);
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (around[node].empty() || unknown[node] || d.hanging.hangs(node)) continue;
    surface.nodes.push_back(node);
    surface.faces.insert(surface.faces.end(), around[node].begin(), around[node].end());
    surface.face_start.push_back(static_cast<int>(surface.faces.size()));
  }
  return surface;
}

std::vector<Eigen::Matrix3d> free_directions(const Discretization& d, const Eigen::Matrix3Xd& u) {
  const FreeSurface& surface = d.free_surface;
  std::vector<Eigen::Matrix3d> directions(surface.nodes.size());
  if (directions.empty()) return directions;
  const bool turns = d.shapes.material().kinematics == Kinematics::corotational;
  const Eigen::Matrix3Xd x = turns ? Eigen::Matrix3Xd(d.mesh.nodes + u) : d.mesh.nodes;
  for_parts(static_cast<int>(directions.size()), worth_a_thread(1000), [&](int first, int last) {
    for (int k = first; k < last; ++k) directions[static_cast<std::size_t>(k)] = directions_at(surface, k, x);
  });
  return directions;
}

}  // namespace finegauge
