#include "core/space/block_matrix.hpp"

#include "core/parallel/for_parts.hpp"
#include "core/space/block_kernels.hpp"

namespace finegauge {

void multiply(const BlockMatrix<double>& A, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  const BlockPattern& pattern = *A.pattern;
  y.resize(x.size());
  for_parts(pattern.size(), worth_a_thread(50), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      Lanes<double> row = {};
      multiply_row(A.values.data(), pattern.column.data(), pattern.row_start[i], pattern.row_start[i + 1], x.data(),
                   row);
      for (int k = 0; k < 3; ++k) y[3 * i + k] = row[k];
    }
  });
}

Eigen::SparseMatrix<double> to_sparse(const BlockMatrix<double>& A) {
  const BlockPattern& pattern = *A.pattern;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(9 * static_cast<std::size_t>(pattern.block_count()));
  for (int i = 0; i < pattern.size(); ++i)
    for (int p = pattern.row_start[i]; p < pattern.row_start[i + 1]; ++p)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) entries.emplace_back(3 * i + r, 3 * pattern.column[p] + c, A.block(p)(r, c));
  Eigen::SparseMatrix<double> sparse(3 * pattern.size(), 3 * pattern.size());
  sparse.setFromTriplets(entries.begin(), entries.end());
  return sparse;
}

}  // namespace finegauge
