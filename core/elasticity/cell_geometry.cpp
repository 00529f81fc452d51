#include "core/elasticity/cell_geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace finegauge {

namespace {

/// Values at the eight quadrature points, or at the eight corners: what one vector instruction or two work on.
using Eight = Eigen::Array<double, 8, 1>;

const double gauss_low = 0.5 - 0.5 / std::sqrt(3.0);
const double gauss_high = 0.5 + 0.5 / std::sqrt(3.0);

/// Natural coordinates of the hexahedron's quadrature points and the shape functions' natural derivatives there.
struct HexahedronTable {
  std::array<Eight, 3> xi;                          ///< [axis](point)
  std::array<std::array<Eight, 8>, 3> derivatives;  ///< [axis][corner](point)
  Gradients centre;

  HexahedronTable() {
    for (int q = 0; q < 8; ++q) {
      const Eigen::Vector3d point = quadrature_point(CellShape::hexahedron, q);
      const Gradients dN = shape_gradients(CellShape::hexahedron, point);
      for (int axis = 0; axis < 3; ++axis) {
        xi[axis][q] = point[axis];
        for (int a = 0; a < 8; ++a) derivatives[axis][a][q] = dN(axis, a);
      }
    }
    centre = shape_gradients(CellShape::hexahedron, Eigen::Vector3d::Constant(0.5));
  }
};

const HexahedronTable& hexahedron_table() {
  static const HexahedronTable table;
  return table;
}

/// Coefficients of the trilinear map: X(ξ) = Σ_m column(m) Π_{bits of m} ξ_axis. All but column 0 are differences of
/// corners, free of the cell's place.
CellVectors trilinear_coefficients(const CellVectors& corners) {
  CellVectors c = corners;
  for (int bit = 1; bit < 8; bit *= 2)
    for (int a = 0; a < 8; ++a)
      if (a & bit) c.col(a) -= c.col(a ^ bit);
  return c;
}

CellGeometry hexahedron_geometry(const CellVectors& corners) {
  const HexahedronTable& table = hexahedron_table();
  const CellVectors c = trilinear_coefficients(corners);
  CellGeometry geometry;

  // J[i][k] = ∂X_i / ∂ξ_k at all points at once.
  std::array<std::array<Eight, 3>, 3> J;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    const int bit_k = 1 << k, bit_l = 1 << l, bit_m = 1 << m;
    const Eight product = table.xi[l] * table.xi[m];
    for (int i = 0; i < 3; ++i)
      J[i][k] = c(i, bit_k) + c(i, bit_k | bit_l) * table.xi[l] + c(i, bit_k | bit_m) * table.xi[m] + c(i, 7) * product;
  }
  std::array<std::array<Eight, 3>, 3> inverse;  // [k][i] = ∂ξ_k / ∂X_i, first without the determinant
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, n = (i + 2) % 3;
      inverse[k][i] = J[j][l] * J[n][m] - J[j][m] * J[n][l];
    }
  }
  const Eight det = J[0][0] * inverse[0][0] + J[1][0] * inverse[0][1] + J[2][0] * inverse[0][2];
  const Eight reciprocal = 1.0 / det;
  for (auto& row : inverse)
    for (Eight& entry : row) entry *= reciprocal;

  // Signed: where a child lies in a folded corner of its base cell, the divergence theorem and with it the patch test
  // still hold.
  const Eight weights = 0.125 * det;
  Eigen::Map<Eight>(geometry.weights.data()) = weights;
  geometry.volume = weights.sum();
  const Eight share = weights / geometry.volume;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) {
      const Eight g = table.derivatives[0][a] * inverse[0][i] + table.derivatives[1][a] * inverse[1][i] +
                      table.derivatives[2][a] * inverse[2][i];
      geometry.mean_gradients(i, a) = (share * g).sum();
      for (int q = 0; q < 8; ++q) geometry.gradients[q](i, a) = g[q];
    }

  Eigen::Matrix3d centre;  // columns ∂X / ∂ξ_k
  for (int k = 0; k < 3; ++k) {
    const int bit_k = 1 << k, bit_l = 1 << ((k + 1) % 3), bit_m = 1 << ((k + 2) % 3);
    centre.col(k) = c.col(bit_k) + 0.5 * (c.col(bit_k | bit_l) + c.col(bit_k | bit_m)) + 0.25 * c.col(7);
  }
  Eigen::Matrix3d inverse_transpose;
  for (int k = 0; k < 3; ++k) inverse_transpose.col(k) = centre.col((k + 1) % 3).cross(centre.col((k + 2) % 3));
  inverse_transpose /= centre.col(0).dot(inverse_transpose.col(0));
  geometry.centre_gradients.noalias() = inverse_transpose.lazyProduct(table.centre);
  return geometry;
}

CellGeometry tetrahedron_geometry(const CellVectors& corners) {
  CellGeometry geometry;
  Eigen::Matrix3d J;
  for (int k = 0; k < 3; ++k) J.col(k) = corners.col(k + 1) - corners.col(0);
  Gradients g = Gradients::Zero();
  for (int k = 0; k < 3; ++k) g.col(k + 1) = J.col((k + 1) % 3).cross(J.col((k + 2) % 3));
  const double det = J.col(0).dot(g.col(1));
  g /= det;
  g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
  geometry.gradients.fill(Gradients::Zero());
  geometry.gradients[0] = geometry.centre_gradients = geometry.mean_gradients = g;
  geometry.weights.fill(0.0);
  geometry.weights[0] = geometry.volume = std::abs(det) / 6.0;
  return geometry;
}

CellMatrix hexahedron_stiffness(const CellGeometry& geometry, const Material& material) {
  // s[i](a, q) = sqrt(|w_q|) ∂N_a/∂X_i: with the root of the weight on both factors K is symmetric to the last bit. The
  // weights are taken over a power of two near the volume, or the root would round otherwise in other units.
  const double unit = std::ldexp(1.0, std::ilogb(geometry.volume));
  using Square = Eigen::Array<double, 8, 8>;
  std::array<Eigen::Matrix<double, 8, 8>, 3> s, signed_s;
  for (int q = 0; q < 8; ++q) {
    const double root = std::sqrt(std::abs(geometry.weights[q]) / unit);
    for (int i = 0; i < 3; ++i) s[i].col(q) = root * geometry.gradients[q].row(i).transpose();
  }
  for (int i = 0; i < 3; ++i)
    for (int q = 0; q < 8; ++q) signed_s[i].col(q) = std::copysign(1.0, geometry.weights[q]) * s[i].col(q);
  std::array<std::array<Square, 3>, 3> S;  // S[i][j](a, b) = Σ_q w ∂N_a/∂X_i ∂N_b/∂X_j
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) S[i][j] = signed_s[i].lazyProduct(s[j].transpose()).array();

  const double mu = unit * material.mu();
  const bool mean = material.dilatation == Dilatation::mean;
  const double volumetric = mean ? -2.0 / 3.0 * mu : unit * material.lambda();
  const double mean_bulk = mean ? material.bulk() * geometry.volume : 0.0;
  CellMatrix K;
  for (int b = 0; b < 8; ++b) {
    const Eight trace = mu * (S[0][0].col(b) + S[1][1].col(b) + S[2][2].col(b));
    for (int j = 0; j < 3; ++j) {
      std::array<Eight, 3> rows;
      for (int i = 0; i < 3; ++i) {
        rows[i] = volumetric * S[i][j].col(b) + mu * S[j][i].col(b);
        if (mean) {
          const Eight mean_i = geometry.mean_gradients.row(i).transpose().array();
          rows[i] += mean_bulk * (mean_i * geometry.mean_gradients(j, b));
        }
      }
      rows[j] += trace;
      double* column = K.data() + 24 * (3 * b + j);
      for (int a = 0; a < 8; ++a) {
        column[3 * a] = rows[0][a];
        column[3 * a + 1] = rows[1][a];
        column[3 * a + 2] = rows[2][a];
      }
    }
  }
  return K;
}

CellMatrix tetrahedron_stiffness(const CellGeometry& geometry, const Material& material) {
  CellMatrix K = CellMatrix::Zero();
  const Gradients& g = geometry.gradients[0];
  const double w = geometry.weights[0], mu = material.mu(), lambda = material.lambda();
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const double trace = i == j ? g(0, a) * g(0, b) + g(1, a) * g(1, b) + g(2, a) * g(2, b) : 0.0;
          K(3 * a + i, 3 * b + j) = w * (lambda * (g(i, a) * g(j, b)) + mu * (g(j, a) * g(i, b)) + mu * trace);
        }
  return K;
}

/// Rows of the gradients, all corners at once.
std::array<Eight, 3> by_component(const Gradients& gradients) {
  std::array<Eight, 3> rows;
  for (int i = 0; i < 3; ++i) rows[i] = gradients.row(i).transpose().array();
  return rows;
}

}  // namespace

Eigen::Vector3d quadrature_point(CellShape shape, int q) {
  if (shape == CellShape::tetrahedron) return Eigen::Vector3d::Constant(0.25);
  return {(q & 1) ? gauss_high : gauss_low, (q & 2) ? gauss_high : gauss_low, (q & 4) ? gauss_high : gauss_low};
}

CellGeometry cell_geometry(CellShape shape, const CellVectors& corners) {
  return shape == CellShape::hexahedron ? hexahedron_geometry(corners) : tetrahedron_geometry(corners);
}

CellMatrix cell_stiffness(CellShape shape, const CellGeometry& geometry, const Material& material) {
  return shape == CellShape::hexahedron ? hexahedron_stiffness(geometry, material)
                                        : tetrahedron_stiffness(geometry, material);
}

Gradients material_gradients(const CellVectors& corners, const MaterialMeans& means) {
  const Eigen::Vector3d edges = corners.col(7) - corners.col(0);
  assert((corners.col(1) - corners.col(0)).tail<2>().norm() <= 1e-9 * edges.norm() && edges.minCoeff() > 0.0);
  Gradients average;
  for (int axis = 0; axis < 3; ++axis) {
    const int l = (axis + 1) % 3, m = (axis + 2) % 3;
    const double product = means[3 + axis];  // of the two coordinates across
    for (int a = 0; a < 8; ++a) {
      const bool high_l = (a >> l) & 1, high_m = (a >> m) & 1;
      const double across = high_l && high_m ? product
                            : high_l         ? means[l] - product
                            : high_m         ? means[m] - product
                                             : 1.0 - means[l] - means[m] + product;
      average(axis, a) = ((a >> axis) & 1 ? across : -across) / edges[axis];
    }
  }
  return average;
}

CellMatrix partial_stiffness(const CellGeometry& geometry, const CellMatrix& full, const Gradients& average,
                             double share, const Material& material) {
  const double scale = std::max(share, least_stiffness_share), weight = share * geometry.volume;
  const double mu = weight * material.mu(), lambda = weight * material.lambda();
  const std::array<Eight, 3> g = by_component(average), f = by_component(geometry.mean_gradients);
  CellMatrix K;
  for (int b = 0; b < 8; ++b) {
    const Eight trace =
        mu * ((g[0] * g[0][b] + g[1] * g[1][b] + g[2] * g[2][b]) - (f[0] * f[0][b] + f[1] * f[1][b] + f[2] * f[2][b]));
    for (int j = 0; j < 3; ++j) {
      const double* from = full.data() + 24 * (3 * b + j);
      double* column = K.data() + 24 * (3 * b + j);
      for (int i = 0; i < 3; ++i) {
        Eight entry = lambda * (g[i] * g[j][b] - f[i] * f[j][b]) + mu * (g[j] * g[i][b] - f[j] * f[i][b]);
        if (i == j) entry += trace;
        for (int a = 0; a < 8; ++a) column[3 * a + i] = scale * from[3 * a + i] + entry[a];
      }
    }
  }
  return K;
}

}  // namespace finegauge
