#pragma once

#include <limits>
#include <string>
#include <vector>

namespace finegauge {

/// A chart's axis: data to pixels, and where its ticks stand.
struct ChartAxis {
  bool logarithmic = false;
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  double from_px = 0.0, to_px = 1.0;

  bool takes(double value) const;  ///< finite, and positive on a logarithmic axis
  void include(double value);      ///< values that it does not take are passed over
  /// Room on both sides, as a share of the range; a range of nothing becomes one of something.
  void widen(double share);
  double pixel(double value) const;
  /// About `wanted` round numbers within the range: 1, 2 and 5 times powers of ten; whole powers on an axis of decades.
  std::vector<double> ticks(int wanted) const;
};
/// Of all ticks of an axis, each with the digits that it needs.
std::vector<std::string> tick_labels(const std::vector<double>& ticks);

}  // namespace finegauge
