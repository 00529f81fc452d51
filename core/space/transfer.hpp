#pragma once

#include <Eigen/Core>

#include "core/mesh/mesh.hpp"

namespace finegauge {

/// A conforming nodal field of one mesh on another mesh of the same forest. Where the new mesh is finer the field is
/// kept exactly; where it is coarser the values at the nodes that remain are kept. One change of
/// template is two transfers (mesh/nested_meshes.hpp).
Eigen::Matrix3Xd transfer(const Mesh& from, const Eigen::Matrix3Xd& nodal, const Mesh& to);

}  // namespace finegauge
