#include "benchmarks/report/curve_reduction.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace finegauge {
namespace {

std::vector<PlotPoint> by_columns(const std::vector<PlotPoint>& points, double column) {
  std::vector<PlotPoint> kept;
  for (std::size_t begin = 0; begin < points.size();) {
    const double number = std::floor(points[begin].x / column);
    std::size_t end = begin, lowest = begin, highest = begin;
    for (; end < points.size() && std::floor(points[end].x / column) == number; ++end) {
      if (points[end].y < points[lowest].y) lowest = end;
      if (points[end].y > points[highest].y) highest = end;
    }
    std::array<std::size_t, 4> keep = {begin, lowest, highest, end - 1};
    std::ranges::sort(keep);
    const auto* const last = std::unique(keep.begin(), keep.end());
    for (const auto* k = keep.begin(); k != last; ++k) kept.push_back(points[*k]);
    begin = end;
  }
  return kept;
}

}  // namespace

std::vector<PlotPoint> reduced_curve(const std::vector<PlotPoint>& points, double width, std::size_t at_most) {
  double column = 1.0;
  std::vector<PlotPoint> kept = by_columns(points, column);
  while (kept.size() > at_most && column < width) kept = by_columns(points, column *= 2.0);
  return kept;
}

}  // namespace finegauge
