#pragma once

#include <string>
#include <vector>

namespace finegauge {

// Charts as SVG within HTML: colours are classes of the page's style, so that they follow its dark mode; exact values
// stand in <title> elements, which browsers show on hovering and the page's script shows better.

struct ChartSeries {
  std::string label;
  std::vector<double> x, y;  ///< a pair that cannot be drawn (not finite, not positive on a logarithmic axis) is a gap
  bool line = true, points = false;
  int color = -1;                       ///< of 7; -1: that of its place among the series
  std::vector<std::string> hover = {};  ///< of each point instead of its coordinates
  bool steps = false;                   ///< the line keeps a point's value up to the next point
};
/// The area between two curves over x.
struct ChartBand {
  std::string label;
  std::vector<double> x, low, high;
  int color = 0;
};
/// Bars between edges that meet; one edge more than counts.
struct ChartBars {
  std::string label;
  std::vector<double> edges, counts;
  int color = 0;
};
/// A straight line through the whole chart, with a label at its end.
struct ChartRule {
  double at;
  std::string label;
  bool vertical = false;
};

struct Chart {
  std::string title;             ///< for readers that see no picture
  std::string x_label, y_label;  ///< with units in brackets
  bool log_x = false, log_y = false;
  bool y_from_zero = false;
  bool nearest_point = false;  ///< what hovering finds: the point nearest in the plane and not nearest in x
  std::vector<ChartSeries> series = {};
  std::vector<ChartBand> bands = {};
  std::vector<ChartBars> bars = {};
  std::vector<ChartRule> rules = {};
};

/// Whether there is anything in it to draw.
bool drawable(const Chart& chart);
/// The drawing and, where there is more than one thing in it, its legend above it.
std::string chart_html(const Chart& chart);

/// Histogram over logarithmic bins of equal ratio; empty without a positive finite value.
ChartBars histogram(const std::string& label, const std::vector<double>& values, int bins = 36);
/// How many values are between these edges; those beyond the first and the last count in the bins there.
ChartBars histogram_over(const std::vector<double>& edges, const std::vector<double>& values);

/// One of several horizontal bars per row, side by side: panels of unlike quantities over the same rows.
struct BarPanel {
  std::string title;           ///< with its unit in brackets
  std::vector<double> values;  ///< one per row
  double reference = 0.0;      ///< a line across the rows; 0: none but the axis
};
std::string bar_panels_html(const std::string& title, const std::vector<std::string>& rows,
                            const std::vector<BarPanel>& panels);

/// Where values lie between two bounds, a row each, drawn over the share (value - low) / (high - low).
struct BoundedValue {
  std::string name;
  double low, value, high;
  bool ok;
};
std::string bounds_html(const std::string& title, const std::vector<BoundedValue>& rows);

/// A line without axes for a table's cell; the last value has a dot.
std::string sparkline_svg(const std::string& title, const std::vector<double>& values);

}  // namespace finegauge
