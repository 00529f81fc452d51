#include "core/adapt/patch_polynomial.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

namespace finegauge {

namespace {

using Basis = Eigen::Matrix<double, 8, 1>;

Basis basis_values(const Eigen::Vector3d& y) {
  const double xy = y.x() * y.y();
  return Basis{1.0, y.x(), y.y(), xy, y.z(), y.z() * y.x(), y.y() * y.z(), xy * y.z()};
}

/// In place, by Gauss-Jordan steps, which need no pivoting for a symmetric positive definite matrix; false where the
/// matrix is not one to working precision.
template <int n>
bool invert_positive_definite(Eigen::Matrix<double, n, n>& a) {
  const Eigen::Matrix<double, n, 1> diagonal = a.diagonal();
  for (int k = 0; k < n; ++k) {
    const double pivot = a(k, k);
    if (!(pivot > 1e-14 * diagonal[k])) return false;
    Eigen::Matrix<double, n, 1> column = a.col(k);
    column[k] = 0.0;
    const double reciprocal = 1.0 / pivot;
    for (int j = 0; j < n; ++j) {
      if (j == k) continue;
      const double factor = a(k, j) * reciprocal;
      a.col(j) -= factor * column;
      a(k, j) = factor;
    }
    a.col(k) = (-reciprocal) * column;
    a(k, k) = reciprocal;
  }
  return true;
}

template <int n>
double one_norm(const Eigen::Matrix<double, n, n>& symmetric) {
  std::array<double, n> sums{};  // by rows, all at once
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) sums[i] += std::abs(symmetric(i, j));
  return *std::max_element(sums.begin(), sums.end());
}

template <int n>
struct Fit {
  Eigen::Matrix<double, 6, n> coefficients;  ///< normal⁻¹ · moments
  double condition;
};

/// Nothing where the condition exceeds the bound.
template <int n>
std::optional<Fit<n>> solve_normal_equations(const Eigen::Matrix<double, n, n>& normal,
                                             const Eigen::Matrix<double, 6, n>& moments) {
  Eigen::Matrix<double, n, n> inverse = normal;
  if (!invert_positive_definite(inverse)) return std::nullopt;
  const double condition = one_norm<n>(normal) * one_norm<n>(inverse);
  if (!(condition <= largest_patch_condition)) return std::nullopt;
  return Fit<n>{moments.lazyProduct(inverse), condition};  // no general product: no packing, no heap
}

/// Column c -> Σ over corners with the signs of term c, divided by 8: the coefficients of the trilinear function that
/// has the given values at the corners of [-1, 1]³.
template <int rows>
void corner_values_to_coefficients(Eigen::Matrix<double, rows, 8>& v) {
  for (const int step : {1, 2, 4})
    for (int c = 0; c < 8; ++c) {
      if (c & step) continue;
      const Eigen::Matrix<double, rows, 1> low = v.col(c), high = v.col(c + step);
      v.col(c) = 0.5 * (low + high);
      v.col(c + step) = 0.5 * (high - low);
    }
}

/// Centres whose extents differ by more than this lie in a plane but for the round-off of their coordinates, which is
/// 1e-15 of a patch of a body of ten cells and a thousand times that for one far from the origin. Patches of the
/// flattest cells, 1:10⁶, are well above.
constexpr double flattest_patch = 1e-10;

constexpr std::array<int, 4> linear_terms = {0, 1, 2, 4};

}  // namespace

Voigt PatchPolynomial::operator()(const Eigen::Vector3d& X) const {
  if (basis == PatchBasis::mean) return coefficients.col(0);
  return coefficients.lazyProduct(basis_values(to_patch * (X - origin)));
}

double PatchPolynomial::distance(const Eigen::Vector3d& X) const {
  return (to_patch * (X - origin)).cwiseAbs().maxCoeff();
}

PatchPolynomial fit_patch(std::span<const int> cells, const Eigen::Matrix3Xd& centres, const VoigtColumns& values,
                          const Eigen::Matrix3d& axes, PatchBasis most) {
  PatchPolynomial p;
  Voigt sum = Voigt::Zero();
  for (const int cell : cells) sum += values.col(cell);
  p.coefficients.col(0) = sum / static_cast<double>(cells.size());
  if (most == PatchBasis::mean || cells.size() < 4) return p;

  const Eigen::Vector3d first = centres.col(cells[0]);
  const Eigen::Matrix3d to_axes = axes.inverse();
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  for (const int cell : cells) {
    const Eigen::Vector3d y = to_axes * (centres.col(cell) - first);
    low = low.cwiseMin(y);
    high = high.cwiseMax(y);
  }
  const Eigen::Vector3d half = 0.5 * (high - low);
  if (!(half.minCoeff() > flattest_patch * half.maxCoeff())) return p;  // coplanar
  p.origin = first + axes * (0.5 * (low + high));
  p.to_patch = half.cwiseInverse().asDiagonal() * to_axes;

  Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 6, 8> moments = Eigen::Matrix<double, 6, 8>::Zero();
  for (const int cell : cells) {
    const Basis b = basis_values(p.to_patch * (centres.col(cell) - p.origin));
    for (int k = 0; k < 8; ++k) {
      normal.col(k) += b[k] * b;
      moments.col(k) += b[k] * values.col(cell);
    }
  }
  if (most == PatchBasis::trilinear && cells.size() >= 8) {
    if (const auto fit = solve_normal_equations<8>(normal, moments)) {
      p.coefficients = fit->coefficients;
      p.condition = fit->condition;
      p.basis = PatchBasis::trilinear;
      return p;
    }
  }
  Eigen::Matrix4d linear_normal;
  Eigen::Matrix<double, 6, 4> linear_moments;
  for (int j = 0; j < 4; ++j) {
    linear_moments.col(j) = moments.col(linear_terms[j]);
    for (int i = 0; i < 4; ++i) linear_normal(i, j) = normal(linear_terms[i], linear_terms[j]);
  }
  if (const auto fit = solve_normal_equations<4>(linear_normal, linear_moments)) {
    for (int k = 0; k < 4; ++k) p.coefficients.col(linear_terms[k]) = fit->coefficients.col(k);
    p.condition = fit->condition;
    p.basis = PatchBasis::linear;
  }
  return p;
}

OctantFit fit_octants(const std::array<int, 8>& cells, const Eigen::Matrix3Xd& centres, const VoigtColumns& values) {
  OctantFit fit;
  const Eigen::Vector3d first = centres.col(cells[0]);
  Eigen::Matrix<double, 3, 8> shape;
  for (int k = 0; k < 8; ++k) shape.col(k) = centres.col(cells[k]) - first;
  corner_values_to_coefficients(shape);
  fit.linear_part << shape.col(1), shape.col(2), shape.col(4);

  // Positions carry the round-off of coordinates that may be large against the patch; past 2^-40 of each direction's
  // length the patch is treated as distorted, which costs time and nothing else.
  const double bend = std::max({shape.col(3).cwiseAbs().maxCoeff(), shape.col(5).cwiseAbs().maxCoeff(),
                                shape.col(6).cwiseAbs().maxCoeff(), shape.col(7).cwiseAbs().maxCoeff()});
  const Eigen::Vector3d lengths(shape.col(1).norm(), shape.col(2).norm(), shape.col(4).norm());
  const double volume = fit.linear_part.determinant();
  fit.is_lattice = bend <= std::ldexp(lengths.minCoeff(), -40) && std::abs(volume) > 1e-6 * lengths.prod();
  if (!fit.is_lattice) return fit;

  PatchPolynomial& p = fit.polynomial;
  p.basis = PatchBasis::trilinear;
  p.origin = first + shape.col(0);
  p.to_patch = fit.linear_part.inverse();
  for (int k = 0; k < 8; ++k) p.coefficients.col(k) = values.col(cells[k]);
  corner_values_to_coefficients(p.coefficients);
  return fit;
}

}  // namespace finegauge
