#include "core/space/transfer.hpp"

#include <cassert>

#include "core/mesh/nested_meshes.hpp"
#include "core/space/nested_nodes.hpp"

namespace finegauge {

Eigen::Matrix3Xd transfer(const Mesh& from, const Eigen::Matrix3Xd& nodal, const Mesh& to) {
  Eigen::Matrix3Xd result = Eigen::Matrix3Xd::Zero(3, to.node_count());
  const int corners = corner_count(to.shape);
  visit_nested_leaves(from, to, [&](int old_cell, int new_cell) {
    const LeafFrame &old_leaf = from.frames[old_cell], &new_leaf = to.frames[new_cell];
    if (new_leaf.depth < old_leaf.depth) {
      for (int c = 0; c < corners; ++c)
        for (int a = 0; a < corners; ++a)
          if (lattice_corner(to.shape, new_leaf, c) == lattice_corner(from.shape, old_leaf, a))
            result.col(to.cells[new_cell][c]) = nodal.col(from.cells[old_cell][a]);
      return;
    }
    for (int c = 0; c < corners; ++c) {
      auto value = result.col(to.cells[new_cell][c]);
      if (new_leaf.depth == old_leaf.depth) {
        value = nodal.col(from.cells[old_cell][c]);
        continue;
      }
      const auto N =
          shape_functions(from.shape, natural_coordinates(from.shape, old_leaf, lattice_corner(to.shape, new_leaf, c)));
      value.setZero();
      for (int a = 0; a < corners; ++a)
        if (N[a] != 0.0) value += N[a] * nodal.col(from.cells[old_cell][a]);
    }
  });
  return result;
}

Eigen::MatrixXd transfer_forces(const Discretization& from, const Eigen::MatrixXd& forces, const Discretization& to) {
  assert(forces.rows() == from.dof_count());
  const std::vector<OldNode> old = find_old_nodes(from.mesh, to.mesh);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(to.dof_count(), forces.cols());
  for (int f = 0; f < from.hanging.reduced_count(); ++f)
    visit_row(to, old[from.hanging.node_of[f]],
              [&](int i, double weight) { result.middleRows<3>(3 * i) += weight * forces.middleRows<3>(3 * f); });
  return result;
}

}  // namespace finegauge
