#pragma once

#include <cstddef>
#include <vector>

namespace finegauge {

struct PlotPoint {
  double x, y;  ///< [px]
};

/// A curve with fewer points and the same drawing: of consecutive points in one column of pixels the first, the lowest,
/// the highest and the last stay, in their order (Jugel, Jerzak, Hackenbroich and Markl 2014, "M4"), so that no extreme
/// is lost. Consecutive, since a needle goes back and forth: a loop stays a loop. Where more than `at_most` points are
/// left, columns are taken twice as wide until they fit; that needs at_most >= 4 and an x that does not leap from
/// column to column at every point (else the widest column is the whole drawing, `width`).
std::vector<PlotPoint> reduced_curve(const std::vector<PlotPoint>& points, double width, std::size_t at_most);

}  // namespace finegauge
