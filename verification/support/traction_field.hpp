#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/mesh.hpp"

namespace finegauge {

/// Force per area [Pa] at the rest position X on a face whose outward unit normal there is n.
using TractionField = std::function<Eigen::Vector3d(const Eigen::Vector3d& X, const Eigen::Vector3d& n)>;

/// Nodal forces [N], 3 × n_nodes, of a traction that varies over a named surface of hexahedra: what `nodal_loads` does
/// not take. 3×3 Gauss points on each leaf's face, as it is: bilinear, not the surface that it stands for. A uniform
/// pressure is integrated exactly. Throws std::invalid_argument when no face belongs to the surface.
Eigen::Matrix3Xd traction_forces(const BaseMesh& base, const Mesh& mesh, const std::string& surface,
                                 const TractionField& traction);

}  // namespace finegauge
