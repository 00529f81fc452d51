#include <algorithm>
#include <cmath>

#include "benchmarks/report/chart.hpp"
#include "benchmarks/report/chart_text.hpp"
#include "benchmarks/report/html.hpp"

namespace finegauge {
namespace {

constexpr double panels_width = 560.0, row_height = 36.0, head = 26.0;

std::string begin_svg(const std::string& title, double height) {
  return "<svg class=\"chart rows\" viewBox=\"0 0 560 " + pixels(height) + "\" role=\"img\" aria-label=\"" +
         html_escaped(title) + "\">\n";
}

/// Beside one row's bar only, so that no line runs through the names above the bars.
std::string upright(double x, double y, const char* style) {
  return std::string("<path class=\"") + style + "\" d=\"M" + pixels(x) + " " + pixels(y - 3.0) + "v19\"/>";
}

}  // namespace

std::string bar_panels_html(const std::string& title, const std::vector<std::string>& rows,
                            const std::vector<BarPanel>& panels) {
  const double height = head + row_height * static_cast<double>(rows.size()) + 4.0;
  const double gap = 22.0, panel_width = (panels_width - gap * static_cast<double>(panels.size() - 1)) /
                                         static_cast<double>(panels.size());
  const double number_room = 58.0;  // of the value beside its bar
  std::string svg = begin_svg(title, height);
  for (std::size_t p = 0; p < panels.size(); ++p) {
    const BarPanel& panel = panels[p];
    const double begin = (panel_width + gap) * static_cast<double>(p);
    double low = std::min(0.0, panel.reference), high = std::max(0.0, panel.reference);
    for (const double value : panel.values)
      if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    if (!(high > low)) high = low + 1.0;
    const double from = begin + (low < 0.0 ? number_room : 0.0),
                 to = begin + panel_width - (high > 0.0 ? number_room : 0.0);
    const auto at = [&](double value) { return from + (to - from) * (value - low) / (high - low); };
    svg += chart_text(begin, 15.0, "name", panel.title);
    for (std::size_t r = 0; r < rows.size() && r < panel.values.size(); ++r) {
      const double y = head + row_height * static_cast<double>(r) + 18.0, value = panel.values[r];
      svg += upright(at(0.0), y, "axis");
      if (panel.reference != 0.0) svg += upright(at(panel.reference), y, "rule");
      if (!std::isfinite(value)) {
        svg += chart_text(at(0.0) + 4.0, y + 11.0, "tick", "not told");
        continue;
      }
      svg += "<rect class=\"bar c" + std::to_string(p) + "\" x=\"" + pixels(std::min(at(0.0), at(value))) + "\" y=\"" +
             pixels(y) + "\" width=\"" + pixels(std::max(1.0, std::abs(at(value) - at(0.0)))) +
             "\" height=\"13\"><title>" + html_escaped(rows[r] + ": " + panel.title + " " + number_text(value)) +
             "</title></rect>" +
             chart_text(at(value) + (value < 0.0 ? -5.0 : 5.0), y + 11.0, value < 0.0 ? "tick end" : "tick",
                        number_text(value));
    }
  }
  for (std::size_t r = 0; r < rows.size(); ++r)
    svg += chart_text(0.0, head + row_height * static_cast<double>(r) + 13.0, "row", rows[r]);
  return svg + "</svg>\n";
}

std::string bounds_html(const std::string& title, const std::vector<BoundedValue>& rows) {
  const double height = head + row_height * static_cast<double>(rows.size()) + 4.0, from = 60.0, to = 500.0;
  std::string svg = begin_svg(title, height);
  svg += chart_text(from, 15.0, "name mid", "low") + chart_text(to, 15.0, "name mid", "high");
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const BoundedValue& row = rows[r];
    const double y = head + row_height * static_cast<double>(r), range = row.high - row.low;
    svg += upright(from, y + 18.0, "axis") + upright(to, y + 18.0, "axis");
    // A range of nothing is a value that has to be met exactly: in the middle, or beyond the side on which it is off.
    const double share = range > 0.0            ? (row.value - row.low) / range
                         : row.value == row.low ? 0.5
                         : row.value < row.low  ? -1.0
                                                : 2.0;
    const double at = std::isfinite(share) ? from + (to - from) * std::clamp(share, -0.1, 1.1) : from;
    const std::string told =
        row.name + ": " + number_text(row.value, 4) + " in [" + bound_text(row.low) + ", " + bound_text(row.high) + "]";
    svg += chart_text(0.0, y + 13.0, row.ok ? "row" : "row bad", (row.ok ? "" : "✗ ") + row.name) +
           chart_text(panels_width, y + 13.0, "tick end", number_text(row.value, 4)) + "<path class=\"track\" d=\"M" +
           pixels(from) + " " + pixels(y + 25.0) + "H" + pixels(to) + "\"/>";
    // A mark of another form beside the other colour.
    svg += row.ok
               ? "<circle class=\"dot c0\" cx=\"" + pixels(at) + "\" cy=\"" + pixels(y + 25.0) + "\" r=\"5\">"
               : "<path class=\"cross\" d=\"M" + pixels(at - 5.0) + " " + pixels(y + 20.0) + "l10 10m0 -10l-10 10\">";
    svg += "<title>" + html_escaped(told) + "</title>" + (row.ok ? "</circle>\n" : "</path>\n");
  }
  return svg + "</svg>\n";
}

std::string sparkline_svg(const std::string& title, const std::vector<double>& values) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values)
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  if (!(low <= high)) return "–";
  constexpr double spark_width = 120.0, spark_height = 26.0;
  const double range = high > low ? high - low : 1.0, steps = std::max(1.0, static_cast<double>(values.size()) - 1.0);
  std::string points, last;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const std::string x = pixels(4.0 + (spark_width - 8.0) * static_cast<double>(i) / steps);
    const std::string y =
        pixels(high > low ? spark_height - 4.0 - (spark_height - 8.0) * (values[i] - low) / range : 0.5 * spark_height);
    points.append(points.empty() ? "" : " ").append(x).append(",").append(y);
    last =
        std::string("<circle class=\"dot c0\" cx=\"").append(x).append("\" cy=\"").append(y).append("\" r=\"2.6\"/>");
  }
  return "<svg class=\"spark\" viewBox=\"0 0 120 26\" role=\"img\" aria-label=\"" + html_escaped(title) + "\"><title>" +
         html_escaped(title + ": " + number_text(low, 4) + " to " + number_text(high, 4)) +
         "</title><polyline class=\"line c0\" points=\"" + points + "\"/>" + last + "</svg>";
}

}  // namespace finegauge
