#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>

#include "core/mesh/base_mesh.hpp"

namespace finegauge {

using Mapping = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// The mesh with each node carried to where the mapping says; cells, surfaces and regions stay what they were. The
/// mapping keeps orientation, or the mesh is not sound (`validate`).
BaseMesh mapped(BaseMesh mesh, const Mapping& mapping);

/// The unit cube of lattice cells, mapped: one structured block. Its surfaces x_min .. z_max are the images of the
/// cube's faces. Nodes are those of box_mesh, so neighbours share them by their lattice numbers.
BaseMesh mapped_box(const std::array<int, 3>& cells, const Mapping& mapping);

/// The node at X, to 1e-9 of the body's diagonal. Throws std::invalid_argument when there is none: where a study reads
/// a value is part of its problem, and a mesh without a node there is the wrong mesh.
int node_at(const Eigen::Matrix3Xd& nodes, const Eigen::Vector3d& X);

}  // namespace finegauge
