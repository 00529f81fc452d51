#include "benchmarks/report/chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "benchmarks/report/chart_axis.hpp"
#include "benchmarks/report/chart_text.hpp"
#include "benchmarks/report/curve_reduction.hpp"
#include "benchmarks/report/html.hpp"

namespace finegauge {
namespace {

constexpr double width = 560.0, height = 330.0, left = 66.0, right = 32.0, top = 30.0, bottom = 50.0;
constexpr std::size_t most_points = 4000;  // of one curve: four per column of pixels is half of it
constexpr int colors = 7;

std::string attribute(const char* name, double value) { return std::string(" ") + name + "=\"" + pixels(value) + "\""; }

std::string color_class(int color) { return "c" + std::to_string(color % colors); }

std::string axes_svg(const Chart& chart, const ChartAxis& x, const ChartAxis& y) {
  std::string svg = "<g class=\"grid\">";
  const std::vector<double> x_ticks = x.ticks(5), y_ticks = y.ticks(5);
  for (const double tick : y_ticks)
    svg += "<path d=\"M" + pixels(left) + " " + pixels(y.pixel(tick)) + "H" + pixels(width - right) + "\"/>";
  for (const double tick : x_ticks)
    svg += "<path d=\"M" + pixels(x.pixel(tick)) + " " + pixels(top) + "V" + pixels(height - bottom) + "\"/>";
  svg += "</g><path class=\"axis\" d=\"M" + pixels(left) + " " + pixels(top) + "V" + pixels(height - bottom) + "H" +
         pixels(width - right) + "\"/>\n";
  const std::vector<std::string> x_labels = tick_labels(x_ticks), y_labels = tick_labels(y_ticks);
  for (std::size_t i = 0; i < x_ticks.size(); ++i)
    svg += chart_text(x.pixel(x_ticks[i]), height - bottom + 19.0, "tick mid", x_labels[i]);
  for (std::size_t i = 0; i < y_ticks.size(); ++i)
    svg += chart_text(left - 7.0, y.pixel(y_ticks[i]) + 4.5, "tick end", y_labels[i]);
  svg += chart_text(0.5 * (left + width - right), height - 8.0, "name mid", chart.x_label);
  return svg + chart_text(4.0, 16.0, "name", chart.y_label) + "\n";
}

/// Runs of points that can be drawn, in pixels; with the corners of their steps.
std::vector<std::vector<PlotPoint>> pieces(const ChartSeries& series, const ChartAxis& x, const ChartAxis& y) {
  const std::vector<double>&xs = series.x, &ys = series.y;
  std::vector<std::vector<PlotPoint>> found(1);
  for (std::size_t i = 0; i < std::min(xs.size(), ys.size()); ++i) {
    if (x.takes(xs[i]) && y.takes(ys[i])) {
      if (series.steps && !found.back().empty()) found.back().push_back({x.pixel(xs[i]), found.back().back().y});
      found.back().push_back({x.pixel(xs[i]), y.pixel(ys[i])});
    } else if (!found.back().empty())
      found.emplace_back();
  }
  if (found.back().empty()) found.pop_back();
  return found;
}

std::string points_text(const std::vector<PlotPoint>& points) {
  std::string text;
  for (const PlotPoint& p : points) text += (text.empty() ? "" : " ") + pixels(p.x) + "," + pixels(p.y);
  return text;
}

std::string series_svg(const ChartSeries& series, int color, const ChartAxis& x, const ChartAxis& y) {
  const std::string label = html_escaped(series.label);
  std::string svg = "<g class=\"" + color_class(color) + "\" data-label=\"" + label + "\">";
  if (series.line)
    for (const std::vector<PlotPoint>& piece : pieces(series, x, y))
      svg += "<polyline class=\"line\" points=\"" + points_text(reduced_curve(piece, width, most_points)) +
             "\"><title>" + label + "</title></polyline>\n";
  if (series.points)
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (!x.takes(series.x[i]) || !y.takes(series.y[i])) continue;
      const std::string told = i < series.hover.size() ? series.hover[i]
                                                       : series.label + ": " + number_text(series.x[i], 4) + ", " +
                                                             number_text(series.y[i], 4);
      svg += "<circle class=\"dot\"" + attribute("cx", x.pixel(series.x[i])) + attribute("cy", y.pixel(series.y[i])) +
             " r=\"3.6\"><title>" + html_escaped(told) + "</title></circle>\n";
    }
  return svg + "</g>\n";
}

std::string band_svg(const ChartBand& band, const ChartAxis& x, const ChartAxis& y) {
  std::vector<PlotPoint> outline, back;
  for (std::size_t i = 0; i < band.x.size(); ++i)
    if (x.takes(band.x[i]) && y.takes(band.low[i]) && y.takes(band.high[i])) {
      outline.push_back({x.pixel(band.x[i]), y.pixel(band.high[i])});
      back.push_back({x.pixel(band.x[i]), y.pixel(band.low[i])});
    }
  outline = reduced_curve(outline, width, most_points), back = reduced_curve(back, width, most_points);
  const std::size_t upper = outline.size();
  outline.insert(outline.end(), back.rbegin(), back.rend());
  return "<polygon class=\"band " + color_class(band.color) + "\" data-upper=\"" + std::to_string(upper) +
         "\" points=\"" + points_text(outline) + "\"><title>" + html_escaped(band.label) + "</title></polygon>\n";
}

std::string bars_svg(const ChartBars& bars, const ChartAxis& x, const ChartAxis& y) {
  std::string svg = "<g class=\"bars " + color_class(bars.color) + "\">";
  for (std::size_t i = 0; i < bars.counts.size(); ++i) {
    if (!(bars.counts[i] > 0.0)) continue;
    // A bar of one among thousands would be thinner than a hair: it is the one that matters here.
    const double base = height - bottom, y_top = std::min(y.pixel(bars.counts[i]), base - 2.0);
    const double from = x.pixel(bars.edges[i]), to = x.pixel(bars.edges[i + 1]);
    svg += "<rect" + attribute("x", from + 0.5) + attribute("y", y_top) +
           attribute("width", std::max(0.8, to - from - 1.0)) + attribute("height", base - y_top) + "><title>" +
           html_escaped(number_text(bars.edges[i]) + " to " + number_text(bars.edges[i + 1]) + ": " +
                        count_text(bars.counts[i]) + " " + bars.label) +
           "</title></rect>";
  }
  return svg + "</g>\n";
}

/// Lines through the chart; labels of upright ones go down a step each, so that close ones do not cover each other.
std::string rules_svg(const std::vector<ChartRule>& rules, const ChartAxis& x, const ChartAxis& y) {
  std::string svg;
  int upright = 0;
  for (const ChartRule& rule : rules) {
    const ChartAxis& axis = rule.vertical ? x : y;
    if (!axis.takes(rule.at)) continue;
    const double at = axis.pixel(rule.at);
    if (rule.vertical) {
      const bool far = at > 0.6 * width;
      svg += "<path class=\"rule\" d=\"M" + pixels(at) + " " + pixels(top) + "V" + pixels(height - bottom) + "\"/>" +
             chart_text(at + (far ? -5.0 : 5.0), top + 12.0 + 17.0 * upright++, far ? "note end" : "note", rule.label);
    } else {
      svg += "<path class=\"rule\" d=\"M" + pixels(left) + " " + pixels(at) + "H" + pixels(width - right) + "\"/>" +
             chart_text(width - right - 4.0, at - 5.0, "note end", rule.label);
    }
  }
  return svg;
}

std::string legend_html(const Chart& chart) {
  std::string html;
  int entries = 0;
  const auto add = [&](const std::string& shape, int color, const std::string& label) {
    html += "<span class=\"key\"><i class=\"" + shape + " " + color_class(color) + "\"></i>" + html_escaped(label) +
            "</span>";
    ++entries;
  };
  for (const ChartBars& bars : chart.bars) add("swatch", bars.color, bars.label);
  for (const ChartBand& band : chart.bands) add("swatch band", band.color, band.label);
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const ChartSeries& series = chart.series[i];
    add(series.line ? "stroke" : "point", series.color < 0 ? static_cast<int>(i) : series.color, series.label);
  }
  return entries > 1 ? "<div class=\"legend\">" + html + "</div>\n" : "";
}

/// What the script needs to turn pixels into data.
std::string scales(const ChartAxis& x, const ChartAxis& y) {
  char text[256];
  std::snprintf(text, sizeof text, " data-x=\"%.9g %.9g %d %.1f %.1f\" data-y=\"%.9g %.9g %d %.1f %.1f\"", x.low,
                x.high, x.logarithmic ? 1 : 0, x.from_px, x.to_px, y.low, y.high, y.logarithmic ? 1 : 0, y.from_px,
                y.to_px);
  return text;
}

}  // namespace

bool drawable(const Chart& chart) {
  const ChartAxis x{.logarithmic = chart.log_x}, y{.logarithmic = chart.log_y};
  const auto any = [&](const std::vector<double>& xs, const std::vector<double>& ys) {
    for (std::size_t i = 0; i < std::min(xs.size(), ys.size()); ++i)
      if (x.takes(xs[i]) && y.takes(ys[i])) return true;
    return false;
  };
  return std::ranges::any_of(chart.series, [&](const ChartSeries& s) { return any(s.x, s.y); }) ||
         std::ranges::any_of(chart.bands, [&](const ChartBand& b) { return any(b.x, b.low) && any(b.x, b.high); }) ||
         std::ranges::any_of(chart.bars, [](const ChartBars& b) { return !b.counts.empty(); });
}

std::string chart_html(const Chart& chart) {
  ChartAxis x{.logarithmic = chart.log_x}, y{.logarithmic = chart.log_y};
  x.from_px = left, x.to_px = width - right, y.from_px = height - bottom, y.to_px = top;
  const auto include = [&](const std::vector<double>& xs, const std::vector<double>& ys) {
    for (std::size_t i = 0; i < std::min(xs.size(), ys.size()); ++i)
      if (x.takes(xs[i]) && y.takes(ys[i])) x.include(xs[i]), y.include(ys[i]);
  };
  for (const ChartSeries& series : chart.series) include(series.x, series.y);
  for (const ChartBand& band : chart.bands) include(band.x, band.low), include(band.x, band.high);
  for (const ChartBars& bars : chart.bars) {
    for (const double edge : bars.edges) x.include(edge);
    for (const double count : bars.counts) y.include(count);
  }
  for (const ChartRule& rule : chart.rules) (rule.vertical ? x : y).include(rule.at);
  if (chart.y_from_zero && !chart.log_y) y.include(0.0);
  x.widen(chart.bars.empty() ? 0.02 : 0.01), y.widen(0.06);
  if (chart.y_from_zero && !chart.log_y && y.low < 0.0 && y.low > -0.08 * y.high) y.low = 0.0;

  std::string svg = "<svg class=\"chart\" viewBox=\"0 0 560 330\" role=\"img\" aria-label=\"" +
                    html_escaped(chart.title) + "\"" + scales(x, y) +
                    (chart.nearest_point ? " data-nearest=\"1\"" : "") + ">\n" + axes_svg(chart, x, y);
  for (const ChartBand& band : chart.bands) svg += band_svg(band, x, y);
  for (const ChartBars& bars : chart.bars) svg += bars_svg(bars, x, y);
  svg += rules_svg(chart.rules, x, y);
  for (std::size_t i = 0; i < chart.series.size(); ++i)
    svg += series_svg(chart.series[i], chart.series[i].color < 0 ? static_cast<int>(i) : chart.series[i].color, x, y);
  return legend_html(chart) + svg + "</svg>\n";
}

ChartBars histogram(const std::string& label, const std::vector<double>& values, int bins) {
  double low = std::numeric_limits<double>::infinity(), high = 0.0;
  const auto counts = [](double value) { return std::isfinite(value) && value > 0.0; };
  for (const double value : values)
    if (counts(value)) low = std::min(low, value), high = std::max(high, value);
  ChartBars bars{label, {}, {}, 0};
  if (!(low <= high)) return bars;
  // Narrower than two per cent a bin would tell the clock's noise.
  const double from = std::log(low) - 1e-9, to = std::max(std::log(high) + 1e-9, from + 0.02 * bins);
  for (int i = 0; i <= bins; ++i) bars.edges.push_back(std::exp(from + (to - from) * i / bins));
  bars.counts = histogram_over(bars.edges, values).counts;
  return bars;
}

ChartBars histogram_over(const std::vector<double>& edges, const std::vector<double>& values) {
  ChartBars bars{{}, edges, std::vector<double>(edges.size() - 1, 0.0), 0};
  for (const double value : values) {
    if (!(std::isfinite(value) && value > 0.0)) continue;
    const auto bin = std::upper_bound(edges.begin(), edges.end(), value) - edges.begin() - 1;
    bars.counts[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(bin, 0, std::ssize(bars.counts) - 1))] += 1.0;
  }
  return bars;
}

}  // namespace finegauge
