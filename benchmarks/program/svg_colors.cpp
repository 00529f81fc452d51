#include "benchmarks/program/svg_colors.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace finegauge {
namespace {

// Nine equidistant samples of matplotlib's viridis (Stéfan van der Walt and Nathaniel Smith 2015, public domain CC0).
// Between them the map is so smooth that linear interpolation is within a few of 256 levels.
constexpr std::array<std::uint32_t, 9> viridis_table = {0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c,
                                                        0x28ae80, 0x5ec962, 0xaadc32, 0xfde725};

}  // namespace

std::array<double, 3> viridis(double t) {
  const double at = std::clamp(t, 0.0, 1.0) * (viridis_table.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), viridis_table.size() - 2);
  const double share = at - static_cast<double>(low);
  std::array<double, 3> rgb;
  for (int c = 0; c < 3; ++c) {
    const int shift = 16 - 8 * c;
    rgb[c] =
        ((1.0 - share) * (viridis_table[low] >> shift & 255) + share * (viridis_table[low + 1] >> shift & 255)) / 255;
  }
  return rgb;
}

std::string viridis_text(double t) {
  const std::array<double, 3> rgb = viridis(t);
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", static_cast<int>(std::lround(255 * rgb[0])),
                static_cast<int>(std::lround(255 * rgb[1])), static_cast<int>(std::lround(255 * rgb[2])));
  return text;
}

std::string svg_number(double value, const char* format) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string svg_escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return out;
}

std::string svg_begin(int width, int height) {
  const std::string w = std::to_string(width), h = std::to_string(height);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + w + " " + h + "\" width=\"" + w + "\" height=\"" +
         h + "\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
}

std::string svg_heading(const std::string& title, const std::string& note) {
  return std::string("<text x=\"40\" y=\"42\" ") + svg_font + " font-size=\"20\" fill=\"#111111\">" +
         svg_escaped(title) + "</text>\n<text x=\"40\" y=\"66\" " + svg_font + " font-size=\"14\" fill=\"#555555\">" +
         svg_escaped(note) + "</text>\n";
}

double ColorRange::share(double value) const { return std::clamp((value - low) / (high - low), 0.0, 1.0); }

std::string ColorRange::color(double value) const {
  if (!std::isfinite(value)) return no_value_color;
  return uniform ? one_value_color : viridis_text(std::round(255.0 * share(value)) / 255.0);
}

ColorRange color_range(std::vector<std::pair<double, double>> value_and_area, double low, double largest,
                       double upper_quantile, double resolution) {
  if (value_and_area.empty()) return {};
  double area = 0.0;
  for (const auto& [value, part] : value_and_area) area += part;
  std::sort(value_and_area.begin(), value_and_area.end());
  ColorRange range{low, largest, largest};
  double below = 0.0;
  for (const auto& [value, part] : value_and_area)
    if ((below += part) >= upper_quantile * area) {
      range.high = upper_quantile < 1.0 ? value : largest;
      break;
    }
  // Rounding and the solver's tolerance alone must not fill a field of one value with colours.
  const double least = std::max({1e-12, resolution, 1e-4 * std::max(std::abs(low), std::abs(largest))});
  range.uniform = !(largest - low > least);
  // Where most of the body has one value the colours go on to the largest.
  if (!(range.high - range.low > least)) range.high = largest;
  return range;
}

std::string color_bar_svg(const ColorBar& bar, const ColorRange& range) {
  constexpr double width = 22.0;
  std::string svg;
  const auto text = [&](double x, double y, const std::string& words, const char* more) {
    svg += "<text x=\"" + svg_number(x) + "\" y=\"" + svg_number(y) + "\" " + svg_font + " fill=\"#222222\" " + more +
           ">" + svg_escaped(words) + "</text>\n";
  };
  text(bar.x + width, bar.top - 42.0, bar.quantity, "font-size=\"15\" text-anchor=\"middle\"");
  text(bar.x + width, bar.top - 22.0, bar.unit.empty() ? "(dimensionless)" : "[" + bar.unit + "]",
       "font-size=\"14\" text-anchor=\"middle\"");
  if (range.uniform) {
    text(bar.x + width, bar.top + 6.0, "uniform: " + svg_number(range.low, "%.4g"),
         "font-size=\"14\" text-anchor=\"middle\"");
    return svg;
  }
  constexpr int bands = 96;
  const double height = bar.bottom - bar.top;
  for (int k = 0; k < bands; ++k) {
    const double y = bar.bottom - height * (k + 1) / bands;
    svg += "<rect shape-rendering=\"crispEdges\" x=\"" + svg_number(bar.x) + "\" y=\"" + svg_number(y, "%.2f") +
           "\" width=\"" + svg_number(width) + "\" height=\"" + svg_number(height / bands + 0.5, "%.2f") +
           "\" fill=\"" + viridis_text((k + 0.5) / bands) + "\"/>\n";
  }
  constexpr int ticks = 5;
  const bool clipped = range.largest > range.high;
  for (int k = 0; k < ticks; ++k) {
    const double share = double(k) / (ticks - 1), y = bar.bottom - height * share;
    svg += "<path d=\"M" + svg_number(bar.x + width) + " " + svg_number(y) + "h6\" stroke=\"#444444\"/>\n";
    text(bar.x + width + 10.0, y + 5.0,
         (clipped && k == ticks - 1 ? "≥ " : "") + svg_number(range.low + share * (range.high - range.low), "%.3g"),
         "font-size=\"14\"");
  }
  if (clipped)
    text(bar.x + width, bar.bottom + 32.0, "largest " + svg_number(range.largest, "%.3g"),
         "font-size=\"13\" text-anchor=\"middle\"");
  return svg;
}

}  // namespace finegauge
