#include "core/elasticity/polynomial_cell.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace finegauge {

namespace {

/// Lagrange polynomials on the points i / degree, and their derivatives.
struct LineFunctions {
  std::array<double, 5> value{}, derivative{};
};

LineFunctions line_functions(int degree, double x) {
  LineFunctions line;
  for (int i = 0; i <= degree; ++i) {
    double value = 1.0, derivative = 0.0;
    for (int j = 0; j <= degree; ++j) {
      if (j == i) continue;
      const double slope = static_cast<double>(degree) / (i - j),
                   factor = slope * (x - static_cast<double>(j) / degree);
      derivative = derivative * factor + value * slope;
      value *= factor;
    }
    line.value[i] = value;
    line.derivative[i] = derivative;
  }
  return line;
}

struct VolumeFunctions {
  Eigen::VectorXd N;
  Eigen::Matrix3Xd dN;
};

VolumeFunctions volume_functions(int degree, const Eigen::Vector3d& xi) {
  const int n = degree + 1;
  const std::array<LineFunctions, 3> line = {line_functions(degree, xi[0]), line_functions(degree, xi[1]),
                                             line_functions(degree, xi[2])};
  VolumeFunctions functions{Eigen::VectorXd(n * n * n), Eigen::Matrix3Xd(3, n * n * n)};
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int node = i + n * (j + n * k);
        functions.N[node] = line[0].value[i] * line[1].value[j] * line[2].value[k];
        functions.dN(0, node) = line[0].derivative[i] * line[1].value[j] * line[2].value[k];
        functions.dN(1, node) = line[0].value[i] * line[1].derivative[j] * line[2].value[k];
        functions.dN(2, node) = line[0].value[i] * line[1].value[j] * line[2].derivative[k];
      }
  return functions;
}

}  // namespace

GaussRule gauss_rule(int points) {
  if (points < 1 || points > 8)
    throw std::invalid_argument("gauss_rule: " + std::to_string(points) + " points, but must be 1 to 8");
  GaussRule rule{std::vector<double>(points), std::vector<double>(points)};
  for (int i = 0; i < points; ++i) {
    // Newton's method on the Legendre polynomial, from the customary cosine.
    double x = std::cos(std::numbers::pi * (points - i - 0.25) / (points + 0.5)), derivative = 0.0;
    for (int iteration = 0; iteration < 20; ++iteration) {
      double value = 1.0, before = 0.0;
      for (int k = 1; k <= points; ++k) {
        const double next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k;
        before = value;
        value = next;
      }
      derivative = points * (x * value - before) / (x * x - 1.0);
      x -= value / derivative;
    }
    rule.points[i] = 0.5 * (1.0 + x);
    rule.weights[i] = 1.0 / ((1.0 - x * x) * derivative * derivative);
  }
  return rule;
}

PolynomialCell::PolynomialCell(int degree) : degree_(degree) {
  if (degree < 1 || degree > 4)
    throw std::invalid_argument("PolynomialCell: degree is " + std::to_string(degree) + ", but must be 1 to 4");
  const GaussRule rule = gauss_rule(degree + 2);
  for (int k = 0; k < degree + 2; ++k)
    for (int j = 0; j < degree + 2; ++j)
      for (int i = 0; i < degree + 2; ++i) {
        const Eigen::Vector3d xi(rule.points[i], rule.points[j], rule.points[k]);
        VolumeFunctions functions = volume_functions(degree, xi);
        volume_points_.push_back(
            {xi, rule.weights[i] * rule.weights[j] * rule.weights[k], std::move(functions.N), std::move(functions.dN)});
      }
}

Eigen::Vector3d PolynomialCell::node(int index) const {
  const int n = degree_ + 1;
  const Eigen::Vector3i at(index % n, index / n % n, index / (n * n));
  return at.cast<double>() / degree_;
}

Eigen::VectorXd PolynomialCell::shape_functions(const Eigen::Vector3d& xi) const {
  return volume_functions(degree_, xi).N;
}

Eigen::MatrixXd PolynomialCell::stiffness(const CellVectors& corners, const Material& material) const {
  const int n = node_count();
  // σ = mu (∇u + ∇uᵀ) + of_divergence tr ∇u + bulk × projection, the latter with Dilatation::mean only
  const bool projects = material.dilatation == Dilatation::mean;
  const double mu = material.mu(), of_divergence = projects ? -2.0 / 3.0 * mu : material.lambda();
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  Eigen::MatrixXd products(n, n);  // Σ w ∂_i N_a ∂_j N_b, a pair (i, j) at a time
  std::array<Eigen::MatrixXd, 3> gradients;
  const auto points = static_cast<Eigen::Index>(volume_points_.size());
  for (Eigen::MatrixXd& g : gradients) g.resize(points, n);
  for (Eigen::Index q = 0; q < points; ++q) {
    const VolumePoint& point = volume_points_[q];
    const Eigen::Matrix3d J = corners * shape_gradients(CellShape::hexahedron, point.xi).transpose();
    const double scale = std::sqrt(point.weight * std::abs(J.determinant()));
    const Eigen::Matrix3Xd g = scale * (J.inverse().transpose() * point.dN_dxi);
    for (int i = 0; i < 3; ++i) gradients[i].row(q) = g.row(i);
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      products.noalias() = gradients[i].transpose() * gradients[j];
      // lambda ∂_i v_i ∂_j u_j + mu (∂_j v_i ∂_i u_j), and mu ∂_i v_k ∂_i u_k where i = j
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
          K(3 * a + i, 3 * b + j) += of_divergence * products(a, b);
          K(3 * a + j, 3 * b + i) += mu * products(a, b);
          if (i == j)
            for (int k = 0; k < 3; ++k) K(3 * a + k, 3 * b + k) += mu * products(a, b);
        }
    }
  if (!projects) return K;
  const Eigen::VectorXd volumes = point_volumes(corners);
  const Eigen::MatrixXd basis = orthonormal_polynomials(volumes);
  Eigen::MatrixXd divergence(points, 3 * n);  // times the root of the point's volume
  for (int a = 0; a < n; ++a)
    for (int i = 0; i < 3; ++i) divergence.col(3 * a + i) = gradients[i].col(a);
  const Eigen::MatrixXd coefficients = (volumes.cwiseSqrt().asDiagonal() * basis).transpose() * divergence;
  K.noalias() += material.bulk() * coefficients.transpose() * coefficients;
  return K;
}

Eigen::VectorXd PolynomialCell::point_volumes(const CellVectors& corners) const {
  Eigen::VectorXd volumes(static_cast<Eigen::Index>(volume_points_.size()));
  for (Eigen::Index q = 0; q < volumes.size(); ++q) {
    const VolumePoint& point = volume_points_[q];
    const Eigen::Matrix3d J = corners * shape_gradients(CellShape::hexahedron, point.xi).transpose();
    volumes[q] = point.weight * std::abs(J.determinant());
  }
  return volumes;
}

Eigen::MatrixXd PolynomialCell::orthonormal_polynomials(const Eigen::VectorXd& volumes) const {
  std::vector<std::array<int, 3>> powers;
  for (int total = 0; total < degree_; ++total)
    for (int i = total; i >= 0; --i)
      for (int j = total - i; j >= 0; --j) powers.push_back({i, j, total - i - j});
  Eigen::MatrixXd values(volumes.size(), static_cast<Eigen::Index>(powers.size()));
  for (Eigen::Index q = 0; q < volumes.size(); ++q) {
    const Eigen::Vector3d x = 2.0 * volume_points_[q].xi.array() - 1.0;
    for (std::size_t k = 0; k < powers.size(); ++k)
      values(q, static_cast<Eigen::Index>(k)) =
          std::pow(x[0], powers[k][0]) * std::pow(x[1], powers[k][1]) * std::pow(x[2], powers[k][2]);
  }
  // values = Q R under the weights: Q has the same span.
  const Eigen::LLT<Eigen::MatrixXd> gram(values.transpose() * volumes.asDiagonal() * values);
  return gram.matrixL().solve(values.transpose()).transpose();
}

Eigen::VectorXd PolynomialCell::projected(const CellVectors& corners, const Eigen::VectorXd& values) const {
  const Eigen::VectorXd volumes = point_volumes(corners);
  const Eigen::MatrixXd basis = orthonormal_polynomials(volumes);
  return basis * (basis.transpose() * volumes.cwiseProduct(values));
}

Eigen::Matrix3Xd PolynomialCell::interpolate(const CellVectors& corner_values) const {
  Eigen::Matrix3Xd values(3, node_count());
  for (int i = 0; i < node_count(); ++i) {
    const auto N = finegauge::shape_functions(CellShape::hexahedron, node(i));
    values.col(i).setZero();
    for (int c = 0; c < 8; ++c) values.col(i) += N[c] * corner_values.col(c);
  }
  return values;
}

}  // namespace finegauge
