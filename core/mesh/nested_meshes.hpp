#pragma once

#include <Eigen/Core>
#include <functional>

#include "core/mesh/mesh.hpp"

namespace finegauge {

/// Natural coordinates of a leaf's corner in another leaf of the same base cell.
Eigen::Vector3d natural_coordinates(CellShape shape, const LeafFrame& leaf, const LatticePoint& point);
/// Lattice point of a leaf's corner.
LatticePoint lattice_corner(CellShape shape, const LeafFrame& leaf, int corner);

/// Calls visit(a, b) for every pair of leaves, a of the first mesh and b of the second, of which one contains the
/// other or which are the same, in mesh order. Both are meshes of one forest; between them each leaf was refined,
/// coarsened or kept. A leaf that was coarsened and then refined by another template is two steps, with a mesh in
/// between; taken as one it throws std::logic_error.
void visit_nested_leaves(const Mesh& first, const Mesh& second, const std::function<void(int, int)>& visit);

}  // namespace finegauge
