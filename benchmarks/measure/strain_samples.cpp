#include "benchmarks/measure/strain_samples.hpp"

#include <Eigen/LU>
#include <cassert>

#include "core/elasticity/cell_geometry.hpp"
#include "core/elasticity/rotation.hpp"

namespace finegauge {
namespace {

/// In natural coordinates.
Eigen::Vector3d centre_of_material(const Mesh& mesh, int cell) {
  if (mesh.shape == CellShape::tetrahedron) return Eigen::Vector3d::Constant(0.25);
  if (mesh.means.empty()) return Eigen::Vector3d::Constant(0.5);
  const MaterialMeans& means = mesh.means[cell];
  return {means[0], means[1], means[2]};
}

double volume_of_material(const Mesh& mesh, int cell) {
  return material_share(mesh, cell) * cell_geometry(mesh.shape, corner_values(mesh, cell, mesh.nodes)).volume;
}

/// e:C:e of a strain [Pa].
double energy_density(const Material& material, const Eigen::Matrix3d& strain) {
  const double trace = strain.trace();
  return 2.0 * material.mu() * strain.squaredNorm() + material.lambda() * trace * trace;
}

Eigen::Matrix3d symmetric(const Eigen::Matrix3d& matrix) { return 0.5 * (matrix + matrix.transpose()); }

}  // namespace

Eigen::Matrix3d deformation_gradient(const Mesh& mesh, const Eigen::Matrix3Xd& u, const LeafPoint& point) {
  const CellVectors X = corner_values(mesh, point.cell, mesh.nodes), at = corner_values(mesh, point.cell, u);
  const auto dN = shape_gradients(mesh.shape, point.xi);
  const Eigen::Matrix3d J = X * dN.transpose();
  return Eigen::Matrix3d::Identity() + at * dN.transpose() * J.inverse();
}

StrainSamples sample_strains(const Mesh& mesh, const Eigen::Matrix3Xd& u) {
  const int cells = mesh.cell_count();
  StrainSamples samples{Eigen::Matrix3Xd(3, cells), Eigen::VectorXd(cells),
                        Eigen::Matrix<double, 9, Eigen::Dynamic>(9, cells)};
  for (int cell = 0; cell < cells; ++cell) {
    const LeafPoint at{cell, centre_of_material(mesh, cell)};
    samples.places.col(cell) = interpolate(mesh, mesh.nodes, at);
    samples.volumes[cell] = volume_of_material(mesh, cell);
    samples.gradients.col(cell) = deformation_gradient(mesh, u, at).reshaped();
  }
  return samples;
}

std::vector<std::optional<MaterialPoint>> locate_samples(const BaseMesh& base, const StrainSamples& samples) {
  std::vector<std::optional<MaterialPoint>> points;
  points.reserve(static_cast<std::size_t>(samples.places.cols()));
  int hint = -1;
  for (Eigen::Index i = 0; i < samples.places.cols(); ++i) {
    points.push_back(locate_at_rest(base, samples.places.col(i), hint));
    if (points.back()) hint = points.back()->base_cell;
  }
  return points;
}

StrainDistance strain_distance(const StrainSamples& samples, const std::vector<std::optional<MaterialPoint>>& points,
                               const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                               const Material& material) {
  assert(points.size() == static_cast<std::size_t>(samples.places.cols()));
  StrainDistance sum;
  double left_out = 0.0;  // [m³]
  for (Eigen::Index i = 0; i < samples.places.cols(); ++i) {
    const std::optional<MaterialPoint>& point = points[static_cast<std::size_t>(i)];
    if (!point) {
      left_out += samples.volumes[i];
      continue;
    }
    const Eigen::Matrix3d F_s = samples.gradients.col(i).reshaped(3, 3);
    const Eigen::Matrix3d R =
        material.kinematics == Kinematics::corotational ? nearest_rotation(F_s) : Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d F = deformation_gradient(mesh, u, find_leaf(forest, mesh, *point));
    const double volume = samples.volumes[i];
    sum.difference += volume * energy_density(material, symmetric(R.transpose() * (F - F_s)));
    sum.size += volume * energy_density(material, symmetric(R.transpose() * F_s) - Eigen::Matrix3d::Identity());
  }
  if (left_out > 0.0) sum.left_out = left_out / samples.volumes.sum();
  return sum;
}

}  // namespace finegauge
