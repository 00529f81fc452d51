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

/// sum += one block times the vector's part at its column. (By reference: returning a vector register would depend on
/// the processor's options.) A block's columns are loaded four scalars at a time; the fourth
/// belongs to the next column or block (the matrix ends in padding) and its lane is never read.
template <class Scalar>
inline void add_block_product(const Scalar* block, const Scalar* at, Lanes<Scalar>& sum) {
  Lanes<Scalar> c0, c1, c2;
  load_lanes(block, c0);
  load_lanes(block + 3, c1);
  load_lanes(block + 6, c2);
  sum += (c0 * at[0] + c1 * at[1]) + c2 * at[2];
}

/// sum += Σ A_p x_column(p) over the blocks [first, last). Four partial sums, so that additions need not wait for one
/// another; their order depends on the counts alone.
template <class Scalar>
inline void multiply_row(const Scalar* values, const int* column, int first, int last, const Scalar* x,
                         Lanes<Scalar>& sum) {
  const Scalar* block = values + 9 * static_cast<std::size_t>(first);
  const auto part = [&](int p) { return x + 3 * static_cast<std::size_t>(column[p]); };
  Lanes<Scalar> s0 = {}, s1 = {}, s2 = {}, s3 = {};
  int p = first;
  for (; p + 4 <= last; p += 4, block += 36) {
    add_block_product(block, part(p), s0);
    add_block_product(block + 9, part(p + 1), s1);
    add_block_product(block + 18, part(p + 2), s2);
    add_block_product(block + 27, part(p + 3), s3);
  }
  for (; p < last; ++p, block += 9) add_block_product(block, part(p), s0);
  sum += (s0 + s1) + (s2 + s3);
}

}  // namespace finegauge
