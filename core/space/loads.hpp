#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/mesh.hpp"

namespace finegauge {

/// How a load acts on a surface.
enum class LoadKind {
  traction,       ///< force per area [Pa]
  total_by_area,  ///< a total force [N] shared by area
  total_by_node   ///< a total force [N], an equal part to each node of the surface's base faces' current leaves
};
struct SurfaceLoad {
  std::string surface;
  LoadKind kind = LoadKind::traction;
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
};
using BodyForce = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;  ///< [N/m³] of the rest position

/// Nodal forces [N], 3 × n_nodes, integrated on the leaves: 2×2 Gauss points on a quadrilateral face, three on a
/// triangle; body forces at `body_points_per_axis`³ Gauss points (2 or 3) of a hexahedron, four points of a
/// tetrahedron, times the cell's share of material, as if that lay evenly in it. total_by_node shares among all nodes
/// on the surface, hanging ones too. Throws std::invalid_argument when a surface does not exist.
Eigen::Matrix3Xd nodal_loads(const BaseMesh& base, const Mesh& mesh, const std::vector<SurfaceLoad>& loads,
                             const BodyForce& body = {}, int body_points_per_axis = 2);

}  // namespace finegauge
