#include "verification/support/field_errors.hpp"

#include <gsl/gsl_integration.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

namespace finegauge {

namespace {

struct VolumePoint {
  std::array<double, max_corners> N;
  Gradients dN;  ///< by natural coordinates
  double weight;
};

std::vector<VolumePoint> gauss_legendre(int points_per_axis) {
  if (points_per_axis < 1) throw std::invalid_argument("points_per_axis must be positive");
  using Table = gsl_integration_glfixed_table;
  const std::unique_ptr<Table, void (*)(Table*)> table(gsl_integration_glfixed_table_alloc(points_per_axis),
                                                       gsl_integration_glfixed_table_free);
  std::vector<double> x(points_per_axis), w(points_per_axis);
  for (int i = 0; i < points_per_axis; ++i) gsl_integration_glfixed_point(0.0, 1.0, i, &x[i], &w[i], table.get());
  std::vector<VolumePoint> points;
  for (int k = 0; k < points_per_axis; ++k)
    for (int j = 0; j < points_per_axis; ++j)
      for (int i = 0; i < points_per_axis; ++i) {
        const Eigen::Vector3d xi(x[i], x[j], x[k]);
        points.push_back({shape_functions(CellShape::hexahedron, xi), shape_gradients(CellShape::hexahedron, xi),
                          w[i] * w[j] * w[k]});
      }
  return points;
}

}  // namespace

Voigt discrete_stress(const Material& material, const CellVectors& u, const Gradients& gradients,
                      const Gradients& mean_gradients) {
  const Eigen::Matrix3d H = u * gradients.transpose();
  const double dilatation = material.dilatation == Dilatation::mean ? u.cwiseProduct(mean_gradients).sum() : H.trace();
  Eigen::Matrix3d sigma = material.mu() * (H + H.transpose());
  sigma.diagonal().array() += material.bulk() * dilatation - 2.0 / 3.0 * material.mu() * H.trace();
  Voigt voigt;
  voigt << sigma(0, 0), sigma(1, 1), sigma(2, 2), sigma(0, 1), sigma(1, 2), sigma(2, 0);
  return voigt;
}

FieldErrors field_errors(const Discretization& d, const ManufacturedSolution& exact, const Eigen::Matrix3Xd& u,
                         const Eigen::Matrix<double, 6, Eigen::Dynamic>& nodal_stress, int points_per_axis) {
  const Mesh& mesh = d.mesh;
  const Material& material = d.shapes.material();
  if (mesh.shape != CellShape::hexahedron || material.kinematics != Kinematics::linear)
    throw std::invalid_argument("field_errors: hexahedra with linear kinematics only");
  const std::vector<VolumePoint> points = gauss_legendre(points_per_axis);
  FieldErrors sum;  // of squares, until the end
  sum.cell_energy = Eigen::VectorXd::Zero(mesh.cell_count());
  CellGeometry scratch;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellGeometry& geometry = d.shapes.geometry(mesh, cell, scratch);
    const CellVectors X = corner_values(mesh, cell, mesh.nodes), u_h = corner_values(mesh, cell, u);
    for (const VolumePoint& point : points) {
      const Eigen::Matrix3d J = X * point.dN.transpose();
      const double dV = point.weight * J.determinant();
      const Gradients gradients = J.inverse().transpose() * point.dN;
      Eigen::Vector3d at = Eigen::Vector3d::Zero(), value = Eigen::Vector3d::Zero();
      Voigt recovered = Voigt::Zero();
      for (int c = 0; c < 8; ++c) {
        at += point.N[c] * X.col(c);
        value += point.N[c] * u_h.col(c);
        recovered += point.N[c] * nodal_stress.col(mesh.cells[cell][c]);
      }
      const Eigen::Vector3d exact_value = displacement(exact, at);
      sum.displacement += dV * (value - exact_value).squaredNorm();
      sum.displacement_norm += dV * exact_value.squaredNorm();
      const Voigt sigma = stress(exact, material, at);
      const Voigt error = discrete_stress(material, u_h, gradients, geometry.mean_gradients) - sigma;
      sum.cell_energy[cell] += dV * complementary_product(material, error, error);
      sum.energy_norm += dV * complementary_product(material, sigma, sigma);
      recovered -= sigma;
      sum.recovered_stress += dV * complementary_product(material, recovered, recovered);
    }
  }
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (mesh.on_boundary[node]) continue;
    const Eigen::Vector3d exact_value = displacement(exact, mesh.nodes.col(node));
    sum.nodal += (u.col(node) - exact_value).squaredNorm();
    sum.nodal_norm += exact_value.squaredNorm();
  }
  sum.energy = sum.cell_energy.sum();
  for (double* square : {&sum.displacement, &sum.displacement_norm, &sum.nodal, &sum.nodal_norm, &sum.energy,
                         &sum.energy_norm, &sum.recovered_stress})
    *square = std::sqrt(*square);
  sum.cell_energy = sum.cell_energy.cwiseSqrt().eval();
  return sum;
}

}  // namespace finegauge
