#pragma once

#include <cstring>

namespace finegauge {

/// Four scalars in one register, by the vector extension that GCC and Clang share.
template <class Scalar>
struct LanesOf;
template <>
struct LanesOf<double> {
  typedef double type __attribute__((vector_size(32)));
};
template <>
struct LanesOf<float> {
  typedef float type __attribute__((vector_size(16)));
};
template <class Scalar>
using Lanes = typename LanesOf<Scalar>::type;

template <class Scalar>
inline void load_lanes(const Scalar* from, Lanes<Scalar>& lanes) {
  std::memcpy(&lanes, from, sizeof lanes);
}

/// sum[0] + sum[1] += Σ A_p x_column(p) over the blocks [first, last). A block's columns are loaded four scalars at a
/// time, the fourth belongs to the next column or block (the matrix ends in padding) and its lane is never read.
/// Two sums, even and odd blocks, so that additions need not wait for one another; the order is fixed.
template <class Scalar>
inline void multiply_row(const Scalar* values, const int* column, int first, int last, const Scalar* x,
                         Lanes<Scalar> (&sum)[2]) {
  for (int p = first; p < last; ++p) {
    const Scalar* block = values + 9 * static_cast<std::size_t>(p);
    const Scalar* at = x + 3 * static_cast<std::size_t>(column[p]);
    Lanes<Scalar> c0, c1, c2;
    load_lanes(block, c0);
    load_lanes(block + 3, c1);
    load_lanes(block + 6, c2);
    sum[p & 1] += c0 * at[0] + c1 * at[1] + c2 * at[2];
  }
}

}  // namespace finegauge
