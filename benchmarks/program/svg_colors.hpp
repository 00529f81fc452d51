#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace finegauge {

// What the pictures have in common: colours with their bar, and text.

/// The colour map viridis at t in [0, 1], sRGB in [0, 1]: perceptually uniform, also in grey and for the colour-blind.
std::array<double, 3> viridis(double t);
/// The same as #rrggbb.
std::string viridis_text(double t);

inline constexpr const char* no_value_color = "#bbbbbb";   ///< where there is no value
inline constexpr const char* one_value_color = "#cfe3ec";  ///< where all values are the same: lines show well on it
inline constexpr const char* svg_font = "font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\"";

std::string svg_number(double value, const char* format = "%.1f");
/// With &, < and > as SVG writes them.
std::string svg_escaped(const std::string& text);
/// White, with the user's units in pixels.
std::string svg_begin(int width, int height);
/// Title and a line of notes below it, upper left.
std::string svg_heading(const std::string& title, const std::string& note);

struct ColorRange {
  double low = 0.0, high = 1.0, largest = 1.0;
  bool uniform = false;  ///< one value everywhere, as far as four digits tell
  double share(double value) const;
  /// Of a finite value; grey else.
  std::string color(double value) const;
};
/// From `low` to the value that a share `upper_quantile` of the area does not exceed: a notch's stress has no bound,
/// and would leave the rest of the body in one colour. `value_and_area`: finite values; by area, not by nodes, of which
/// refinement puts most where the values are largest. `largest`: of all values that are shown. Values that differ by no
/// more than `resolution` are one value.
ColorRange color_range(std::vector<std::pair<double, double>> value_and_area, double low, double largest,
                       double upper_quantile, double resolution = 0.0);

struct ColorBar {
  std::string quantity, unit;  ///< unit empty: dimensionless
  double x, top, bottom;       ///< of its rectangle [px]; quantity and unit stand above it
};
/// With five ticks, and the largest value where the colours end before it; the value in its place where there is one.
std::string color_bar_svg(const ColorBar& bar, const ColorRange& range);

}  // namespace finegauge
