#include "core/needle/chain_matrix.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace finegauge {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// What entries of a node's block are measured by: the sums of sizes among its translations and among its rotations.
struct BlockScale {
  double translations, rotations;

  explicit BlockScale(const Matrix6& block)
      : translations(block.topLeftCorner<3, 3>().cwiseAbs().sum()),
        rotations(block.bottomRightCorner<3, 3>().cwiseAbs().sum()) {}
  /// Of the square of an entry (i, j).
  double of(int i, int j) const { return (i < 3 ? translations : rotations) * (j < 3 ? translations : rotations); }
};

struct Inversion {
  bool regular = false;
  int negative = 0;  ///< eigenvalues
};

/// Inverse of a symmetric block by symmetric elimination with pivots of one or two rows (Bunch & Parlett 1971).
Inversion invert(Matrix6 A, const BlockScale& scale, Matrix6& inverse) {
  // Gauss-Jordan on pivots in place (the sweep operator): after all rows have been swept A holds -A⁻¹. Without
  // permutations, so that indices keep their units.
  constexpr double alpha_squared = 0.41;  // ((1 + √17) / 8)²: equal growth by one step of two rows and two of one
  constexpr double smallest = 64.0 * std::numeric_limits<double>::epsilon();
  Matrix6 weight;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) weight(i, j) = 1.0 / scale.of(i, j);
  std::array<int, 6> left = {0, 1, 2, 3, 4, 5};
  int count = 6;
  Inversion result;
  while (count > 0) {
    double best_diagonal = -1.0, best_other = -1.0;
    int k = 0, p = 0, q = 0;  // places in `left`
    for (int i = 0; i < count; ++i) {
      const int row = left[i];
      const double size = A(row, row) * A(row, row) * weight(row, row);
      if (size > best_diagonal) best_diagonal = size, k = i;
      for (int j = 0; j < i; ++j) {
        const double other = A(row, left[j]) * A(row, left[j]) * weight(row, left[j]);
        if (other > best_other) best_other = other, p = i, q = j;
      }
    }
    const double best = std::max(best_diagonal, best_other);
    if (!(best > smallest * smallest && std::isfinite(best))) return result;
    if (best_diagonal >= alpha_squared * best_other) {
      const int row = left[k];
      if (A(row, row) < 0.0) ++result.negative;
      const double d = 1.0 / A(row, row);
      const Eigen::Matrix<double, 6, 1> column = A.col(row);
      A.noalias() -= (d * column) * column.transpose();
      A.col(row) = A.row(row).transpose() = d * column;
      A(row, row) = -d;
      left[k] = left[--count];
    } else {
      const int r = left[p], s = left[q];
      ++result.negative;  // the other of the two is positive: |off-diagonal| exceeds both diagonal entries
      const double a = A(r, r), b = A(r, s), c = A(s, s);
      const double ratio = (a / b) * (c / b) - 1.0;  // determinant over b²
      Eigen::Matrix2d d;
      d << c / b, -1.0, -1.0, a / b;
      d /= b * ratio;
      Eigen::Matrix<double, 6, 2> columns;
      columns << A.col(r), A.col(s);
      const Eigen::Matrix<double, 6, 2> scaled = columns * d;
      A.noalias() -= scaled * columns.transpose();
      A.col(r) = scaled.col(0);
      A.col(s) = scaled.col(1);
      A.row(r) = scaled.col(0).transpose();
      A.row(s) = scaled.col(1).transpose();
      A(r, r) = -d(0, 0);
      A(s, s) = -d(1, 1);
      A(r, s) = A(s, r) = -d(0, 1);
      left[p] = left[--count];  // p > q, so that q's place is still its own
      left[q] = left[--count];
    }
  }
  inverse = -0.5 * (A + A.transpose());
  result.regular = inverse.allFinite();
  return result;
}

}  // namespace

void ChainMatrix::set_zero(int nodes) {
  diagonal.assign(nodes, Matrix6::Zero());
  upper.assign(nodes > 0 ? nodes - 1 : 0, Matrix6::Zero());
}

void multiply(const ChainMatrix& A, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  const int n = A.node_count();
  assert(x.size() == 6 * n && &x != &y);
  y.resize(6 * n);
  for (int i = 0; i < n; ++i) {
    Eigen::Matrix<double, 6, 1> sum = A.diagonal[i] * x.segment<6>(6 * i);
    if (i > 0) sum.noalias() += A.upper[i - 1].transpose() * x.segment<6>(6 * (i - 1));
    if (i + 1 < n) sum.noalias() += A.upper[i] * x.segment<6>(6 * (i + 1));
    y.segment<6>(6 * i) = sum;
  }
}

void ChainFactor::factor(const ChainMatrix& A) {
  const int n = A.node_count();
  inverse_pivots_.resize(n);
  lower_.resize(n > 0 ? n - 1 : 0);
  negative_pivots_ = 0;
  factored_ = false;
  Matrix6 pivot;
  for (int i = 0; i < n; ++i) {
    pivot = A.diagonal[i];
    if (i > 0) pivot.noalias() -= lower_[i - 1] * A.upper[i - 1];
    const Inversion inversion = invert(pivot, BlockScale(A.diagonal[i]), inverse_pivots_[i]);
    if (!inversion.regular) return;
    negative_pivots_ += inversion.negative;
    if (i + 1 < n) lower_[i].noalias() = A.upper[i].transpose() * inverse_pivots_[i];
  }
  factored_ = true;
}

void ChainFactor::solve(Eigen::Ref<Eigen::MatrixXd> x) const {
  const int n = static_cast<int>(inverse_pivots_.size());
  assert(factored_ && x.rows() == 6 * n);
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    auto column = x.col(k);
    for (int i = 1; i < n; ++i) column.segment<6>(6 * i).noalias() -= lower_[i - 1] * column.segment<6>(6 * (i - 1));
    for (int i = n - 1; i >= 0; --i) {
      Eigen::Matrix<double, 6, 1> value = inverse_pivots_[i] * column.segment<6>(6 * i);
      if (i + 1 < n) value.noalias() -= lower_[i].transpose() * column.segment<6>(6 * (i + 1));
      column.segment<6>(6 * i) = value;
    }
  }
}

void hold(const HeldDofs& held, ChainMatrix& A) {
  const int n = A.node_count();
  assert(static_cast<int>(held.size()) == n);
  for (int i = 0; i < n; ++i) {
    if (held[i] == 0u) continue;
    const Eigen::Matrix<double, 6, 1> size = A.diagonal[i].diagonal().cwiseAbs();
    for (int k = 0; k < 6; ++k) {
      if ((held[i] >> k & 1u) == 0u) continue;
      double own = size[k];
      if (!(own > 0.0)) own = k < 3 ? size.head<3>().maxCoeff() : size.tail<3>().maxCoeff();
      A.diagonal[i].row(k).setZero();
      A.diagonal[i].col(k).setZero();
      A.diagonal[i](k, k) = own > 0.0 ? own : 1.0;
      if (i > 0) A.upper[i - 1].col(k).setZero();
      if (i + 1 < n) A.upper[i].row(k).setZero();
    }
  }
}

void hold(const HeldDofs& held, Eigen::VectorXd& x) {
  assert(x.size() == 6 * static_cast<Eigen::Index>(held.size()));
  for (std::size_t i = 0; i < held.size(); ++i)
    for (int k = 0; k < 6; ++k)
      if ((held[i] >> k & 1u) != 0u) x[6 * static_cast<Eigen::Index>(i) + k] = 0.0;
}

}  // namespace finegauge
