#include "core/tissue_forces.hpp"

#include "core/space/cell_sums.hpp"

namespace finegauge {

TissueForces tissue_forces(const Discretization& d, const Eigen::Matrix3Xd& u, const Eigen::Matrix3Xd& w) {
  const CellVectors origin = CellVectors::Zero();
  auto [internal, stiff] = sum_over_cells<2>(d, [&](int cell, const RestShapes::CellView& entry) {
    const auto [X, x, R] = cell_motion(d, cell, entry.geometry, u);
    // R K Rᵀ w is the force of a cell of no size at the positions w.
    return std::array{cell_force(entry.stiffness, R, X, x),
                      cell_force(entry.stiffness, R, origin, corner_values(d.mesh, cell, w))};
  });
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
