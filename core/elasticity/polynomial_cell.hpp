#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/elasticity/cell_geometry.hpp"
#include "core/elasticity/material.hpp"

namespace finegauge {

/// Points and weights of Gauss-Legendre quadrature on [0, 1], 1 to 8 points.
struct GaussRule {
  std::vector<double> points, weights;
};
GaussRule gauss_rule(int points);

/// A hexahedron with Lagrange polynomials of a degree along each natural coordinate, on its straight-edged shape: what
/// local problems are solved on whose solution the trilinear cell cannot follow. Node i + n (j + n k), n = degree + 1,
/// lies at natural coordinates (i, j, k) / degree.
class PolynomialCell {
 public:
  explicit PolynomialCell(int degree);  ///< 1 to 4

  int degree() const { return degree_; }
  int node_count() const { return (degree_ + 1) * (degree_ + 1) * (degree_ + 1); }
  Eigen::Vector3d node(int index) const;  ///< natural coordinates
  Eigen::VectorXd shape_functions(const Eigen::Vector3d& xi) const;

  /// A quadrature point of the volume, degree + 2 of them along each axis.
  struct VolumePoint {
    Eigen::Vector3d xi;
    double weight;            ///< of the reference cell
    Eigen::VectorXd N;        ///< node_count
    Eigen::Matrix3Xd dN_dxi;  ///< 3 × node_count
  };
  const std::vector<VolumePoint>& volume_points() const { return volume_points_; }

  /// ∫ Bᵀ D B [N/m] on a cell with these corners, 3 node_count square, dof 3 node + axis. With Dilatation::mean the
  /// dilatation is projected to the polynomials of total degree `degree` - 1 in the natural coordinates, with which no
  /// cell locks as nu -> 1/2; of degree one that is the trilinear cell's mean.
  Eigen::MatrixXd stiffness(const CellVectors& corners, const Material& material) const;
  /// Values at the volume points of that projection of a scalar given at these points.
  Eigen::VectorXd projected(const CellVectors& corners, const Eigen::VectorXd& values) const;
  /// A trilinear field's values at the nodes, 3 × node_count.
  Eigen::Matrix3Xd interpolate(const CellVectors& corner_values) const;

 private:
  Eigen::VectorXd point_volumes(const CellVectors& corners) const;
  /// Orthonormal polynomials of total degree degree - 1 under these weights: values at the points by rows.
  Eigen::MatrixXd orthonormal_polynomials(const Eigen::VectorXd& volumes) const;

  int degree_;
  std::vector<VolumePoint> volume_points_;
};

}  // namespace finegauge
