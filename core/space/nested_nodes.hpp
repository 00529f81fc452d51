#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/cell_shape.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Where a node of one mesh is on another mesh of the same forest: a node of it, or a point in one of its leaves.
struct OldNode {
  int node = -1;
  int cell = -1;
  Eigen::Vector3d xi = Eigen::Vector3d::Zero();
};
/// Per node of `from`. Nodes that are gone lie in a leaf that was coarsened to.
std::vector<OldNode> find_old_nodes(const Mesh& from, const Mesh& to);

/// visit(i, P_fi) for the reduced nodes i of the new mesh on which the old node f depends, P the interpolation of the
/// new mesh's fields at the old nodes.
template <class Visit>
void visit_row(const Discretization& to, const OldNode& old, const Visit& visit) {
  const auto visit_node = [&](int node, double weight) {
    for (int k = to.hanging.row_start[node]; k < to.hanging.row_start[node + 1]; ++k)
      visit(to.hanging.master[k], weight * to.hanging.weight[k]);
  };
  if (old.node >= 0) return visit_node(old.node, 1.0);
  const std::array<double, max_corners> N = shape_functions(to.mesh.shape, old.xi);
  for (int c = 0; c < corner_count(to.mesh.shape); ++c)
    if (N[c] != 0.0) visit_node(to.mesh.cells[old.cell][c], N[c]);
}

}  // namespace finegauge
