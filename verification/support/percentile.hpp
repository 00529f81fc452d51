#pragma once

#include <cmath>
#include <vector>

namespace finegauge {

/// The value below which a share of the ascending values lies: the one whose rank is nearest. There must be one.
inline double percentile(const std::vector<double>& ascending, double share) {
  return ascending[static_cast<std::size_t>(std::lround(share * static_cast<double>(ascending.size() - 1)))];
}

}  // namespace finegauge
