#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

namespace finegauge {

/// Rows and columns of 3 × 3 blocks, columns ascending in a row. Structurally symmetric.
struct BlockPattern {
  std::vector<int> row_start;  ///< n + 1
  std::vector<int> column;
  std::vector<int> diagonal;  ///< position of the block (i, i)

  int size() const { return static_cast<int>(row_start.size()) - 1; }
  int block_count() const { return static_cast<int>(column.size()); }
};

/// A sparse matrix of 3 × 3 blocks on a pattern that it does not own. Each block is stored by columns; four scalars of
/// padding follow the last one, so that kernels may load four at a time.
template <class Scalar>
struct BlockMatrix {
  const BlockPattern* pattern = nullptr;
  std::vector<Scalar> values;  ///< 9 × blocks + 4

  void reset(const BlockPattern& new_pattern) {
    pattern = &new_pattern;
    values.assign(9 * static_cast<std::size_t>(new_pattern.block_count()) + 4, Scalar(0));
  }
  Eigen::Map<Eigen::Matrix<Scalar, 3, 3>> block(int position) {
    return Eigen::Map<Eigen::Matrix<Scalar, 3, 3>>(values.data() + 9 * static_cast<std::size_t>(position));
  }
  Eigen::Map<const Eigen::Matrix<Scalar, 3, 3>> block(int position) const {
    return Eigen::Map<const Eigen::Matrix<Scalar, 3, 3>>(values.data() + 9 * static_cast<std::size_t>(position));
  }
};

/// y = A x; x and y have 3 × size scalars.
void multiply(const BlockMatrix<double>& A, const Eigen::VectorXd& x, Eigen::VectorXd& y);
/// The scalar matrix, for oracles and for CHOLMOD.
Eigen::SparseMatrix<double> to_sparse(const BlockMatrix<double>& A);

}  // namespace finegauge
