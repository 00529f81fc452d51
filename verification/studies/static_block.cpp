#include "verification/studies/static_block.hpp"

#include <cstdio>

#include "core/equilibrium.hpp"
#include "core/space/loads.hpp"

namespace finegauge {

BlockRow solve_block(const std::array<int, 3>& nodes, Kinematics kinematics) {
  BoxMeshOptions box;
  box.size = {0.04, 0.02, 0.02};
  for (int axis = 0; axis < 3; ++axis) box.cells[axis] = nodes[axis] - 1;
  const RefinementForest forest(box_mesh(box));
  Material material;
  material.youngs_modulus = 1e7;
  material.poisson_ratio = 0.4;
  material.kinematics = kinematics;
  const Discretization d = discretize(forest, material, {{"x_min", std::nullopt, {}}});
  const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, {{"x_max", LoadKind::total_by_node, {0, -40, 0}}});
  EquilibriumOptions options;
  options.method = LinearMethod::direct;
  options.newton_residual = 1e-11;
  options.newton_iterations = 100;
  const Equilibrium equilibrium =
      solve_equilibrium(d, {}, loads, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()), options);
  BlockRow row;
  row.nodes = nodes;
  row.kinematics = kinematics;
  row.converged = equilibrium.converged;
  row.residual = equilibrium.relative_residual;
  row.rest = d.mesh.nodes;
  row.u = equilibrium.u;
  int on_face = 0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const Eigen::Vector3d X = d.mesh.nodes.col(node), u = row.u.col(node);
    row.mean_length += u.norm() / d.mesh.node_count();
    if (X.x() < 0.04 * (1.0 - 1e-9)) continue;
    ++on_face;
    row.face_mean += u;
    if (X.y() > 0.02 * (1.0 - 1e-9) && X.z() > 0.02 * (1.0 - 1e-9)) row.corner = u;
  }
  row.face_mean /= on_face;
  return row;
}

std::string block_table(const std::vector<BlockRow>& rows) {
  std::string text =
      "nodes     kinematics    mean |u| [m]     far face: mean u_x, u_y [m]        corner: u_x, u_y, u_z [m]\n";
  for (const BlockRow& row : rows) {
    char line[300];
    std::snprintf(line, sizeof line, "%2dx%2dx%2d  %-12s %15.9e %17.9e %17.9e  %17.9e %17.9e %17.9e\n", row.nodes[0],
                  row.nodes[1], row.nodes[2], row.kinematics == Kinematics::linear ? "linear" : "corotational",
                  row.mean_length, row.face_mean.x(), row.face_mean.y(), row.corner.x(), row.corner.y(),
                  row.corner.z());
    text += line;
  }
  return text;
}

}  // namespace finegauge
