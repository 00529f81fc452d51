#pragma once

#include <cmath>

namespace finegauge {

/// Where a quantity on three grids, each half the size of the one before, is heading: v(h) = limit + C h^order
/// (Richardson 1911; Roache 1998). Not a number unless the differences shrink and have one sign.
struct Extrapolation {
  double limit, order;
};
inline Extrapolation extrapolate(double coarse, double middle, double fine) {
  const double ratio = (middle - coarse) / (fine - middle);
  return {fine + (fine - middle) / (ratio > 1.0 ? ratio - 1.0 : std::nan("")), std::log2(ratio)};
}

}  // namespace finegauge
