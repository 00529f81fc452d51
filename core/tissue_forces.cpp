#include "core/tissue_forces.hpp"

#include "core/elasticity/cell_response.hpp"

namespace finegauge {

TissueForces tissue_forces(const Discretization& d, const Eigen::Matrix3Xd& u, const Eigen::Matrix3Xd& w) {
  Eigen::Matrix3Xd internal = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  Eigen::Matrix3Xd stiff = internal;
  const CellVectors origin = CellVectors::Zero();
  RestShapes::Entry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const RestShapes::CellView entry = d.shapes.entry(d.mesh, cell, scratch);
    const bool turns = d.shapes.material().kinematics == Kinematics::corotational;
    const CellVectors X = turns ? corner_values(d.mesh, cell, d.mesh.nodes) : CellVectors(CellVectors::Zero());
    const CellVectors x = X + corner_values(d.mesh, cell, u);
    const Eigen::Matrix3d R = cell_rotation(entry.geometry, d.shapes.material(), x);
    const CellVectors f = cell_force(entry.stiffness, R, X, x);
    // R K Rᵀ w is the force of a cell of no size at the positions w.
    const CellVectors Kw = cell_force(entry.stiffness, R, origin, corner_values(d.mesh, cell, w));
    for (int c = 0; c < corner_count(d.mesh.shape); ++c) {
      internal.col(d.mesh.cells[cell][c]) += f.col(c);
      stiff.col(d.mesh.cells[cell][c]) += Kw.col(c);
    }
  }
  add_spring_forces(d.springs, d.mesh, u, internal);
  add_spring_forces(d.springs, d.mesh, w, stiff);
  return {reduce_forces(d.hanging, internal), reduce_forces(d.hanging, stiff)};
}

Eigen::VectorXd anchor_loads(const Discretization& d, double stiffness_damping, double time, double tau) {
  std::vector<Eigen::Vector3d> anchors = anchors_at(d.springs, time + tau);
  if (stiffness_damping != 0.0) {
    const std::vector<Eigen::Vector3d> before = anchors_at(d.springs, time);
    for (std::size_t p = 0; p < anchors.size(); ++p) anchors[p] += stiffness_damping / tau * (anchors[p] - before[p]);
  }
  return reduce_forces(d.hanging, anchor_forces(d.springs, d.mesh, anchors));
}

Eigen::VectorXd mass_times(const Eigen::VectorXd& mass, const Eigen::VectorXd& reduced) {
  Eigen::VectorXd product(reduced.size());
  for (Eigen::Index i = 0; i < mass.size(); ++i) product.segment<3>(3 * i) = mass[i] * reduced.segment<3>(3 * i);
  return product;
}

}  // namespace finegauge
