#include "benchmarks/program/safe_box_picture.hpp"

#include <algorithm>
#include <cmath>

#include "benchmarks/program/svg_colors.hpp"

namespace finegauge {
namespace {

constexpr int width = 1180;
constexpr double bar_left = 400.0, bar_right = 940.0, row_height = 30.0, bar_height = 14.0, group_height = 34.0,
                 top = 112.0;
// Of the colours of the plots (Okabe & Ito 2008), told apart with any common colour blindness.
constexpr const char *answered_color = "#56B4E9", *failing_color = "#c00000", *outline_color = "#8a8a8a";

/// Where a row's values stand on the picture. Zero has a place of its own, left of the smallest positive value.
class Scale {
 public:
  explicit Scale(const std::vector<AtlasPoint>& points) {
    for (const AtlasPoint& point : points) {
      has_zero_ = has_zero_ || point.value == 0.0;
      if (!(point.value > 0.0)) continue;
      low_ = std::min(low_, std::log10(point.value));
      high_ = std::max(high_, std::log10(point.value));
    }
    left_ = bar_left + (has_zero_ ? zero_room : end_room);
  }
  double operator()(double value) const {
    if (!(value > 0.0)) return bar_left + end_room;
    const double right = bar_right - end_room;
    return high_ > low_ ? left_ + (right - left_) * (std::log10(value) - low_) / (high_ - low_) : 0.5 * (left_ + right);
  }
  bool has_zero() const { return has_zero_; }
  double left() const { return left_; }

 private:
  static constexpr double end_room = 8.0, zero_room = 34.0;
  double low_ = INFINITY, high_ = -INFINITY, left_ = bar_left;
  bool has_zero_ = false;
};

std::string text(double x, double y, const std::string& words, const std::string& style) {
  return "<text x=\"" + svg_number(x) + "\" y=\"" + svg_number(y) + "\" " + svg_font + " " + style + ">" +
         svg_escaped(words) + "</text>\n";
}

std::string rectangle(double left, double right, double y, double height, const std::string& style) {
  return "<rect x=\"" + svg_number(left) + "\" y=\"" + svg_number(y) + "\" width=\"" + svg_number(right - left) +
         "\" height=\"" + svg_number(height) + "\" " + style + "/>\n";
}

std::string cross(double x, double y, double size) {
  const std::string s = svg_number(size), d = svg_number(2.0 * size);
  return "<path class=\"failing\" d=\"M" + svg_number(x - size) + " " + svg_number(y - size) + "l" + d + " " + d +
         "m0 -" + d + "l-" + d + " " + d + "\" stroke=\"" + failing_color + "\" stroke-width=\"2\" fill=\"none\"/>\n";
}

std::string spoken(std::string name) {
  std::ranges::replace(name, '_', ' ');
  return name;
}

/// A stretch of a row, reaching a little beyond its ends so that a single value shows.
std::string stretch(const Scale& scale, const AtlasRange& range, double y, const std::string& style) {
  constexpr double beyond = 5.0;
  return rectangle(scale(range.low) - beyond, scale(range.high) + beyond, y, bar_height, style);
}

void draw_row(const SafeBoxRow& row, double y, std::string& svg) {
  const AtlasAxis& axis = *row.axis;
  const std::vector<AtlasPoint>& points = row.found.points;
  const double middle = y + 0.5 * bar_height;
  svg += text(28.0, middle + 4.5, spoken(axis.name) + (axis.unit.empty() ? "" : " [" + axis.unit + "]"),
              "font-size=\"13\" fill=\"#111111\"");
  if (points.empty()) return;
  const Scale scale(points);
  svg += rectangle(bar_left, bar_right, y, bar_height,
                   std::string("fill=\"white\" stroke=\"") + outline_color + "\" stroke-width=\"1\"");
  if (row.found.safe) svg += stretch(scale, *row.found.safe, y, "fill=\"url(#refused)\"");
  if (row.found.answered) svg += stretch(scale, *row.found.answered, y, std::string("fill=\"") + answered_color + "\"");
  if (scale.has_zero() && points.size() > 1) {  // the scale is broken between zero and the smallest value
    const double x = 0.5 * (scale(0.0) + scale.left());
    svg += rectangle(x - 2.5, x + 2.5, y - 2.0, bar_height + 4.0, "fill=\"white\"");
    svg += "<path d=\"M" + svg_number(x - 4.0) + " " + svg_number(y + bar_height + 2.0) + "l3 -" +
           svg_number(bar_height + 4.0) + "m5 0l-3 " + svg_number(bar_height + 4.0) + "\" stroke=\"" + outline_color +
           "\" fill=\"none\"/>\n";
  }
  for (const AtlasPoint& point : points) {
    const double x = scale(point.value);
    if (!point.ok)
      svg += cross(x, middle, 4.5);
    else if (point.refused)
      svg += "<circle cx=\"" + svg_number(x) + "\" cy=\"" + svg_number(middle) +
             "\" r=\"3\" fill=\"white\" stroke=\"#444444\"/>\n";
    else if (const auto& range = row.found.answered; range && point.value >= range->low && point.value <= range->high)
      svg += "<path d=\"M" + svg_number(x) + " " + svg_number(middle - 3.5) + "v7\" stroke=\"#ffffff\"/>\n";
    else  // an answer beyond what is refused or fails
      svg += "<circle cx=\"" + svg_number(x) + "\" cy=\"" + svg_number(middle) + "\" r=\"3\" fill=\"" + answered_color +
             "\"/>\n";
  }
  const double normal = scale(axis.normal);
  svg += "<path d=\"M" + svg_number(normal - 4.0) + " " + svg_number(y - 6.0) + "h8l-4 5z\" fill=\"#222222\"/>\n";
  const auto end = [&](double value, double x, const char* anchor) {
    svg += text(x, middle + 4.0, brief_number(value),
                std::string("font-size=\"11\" fill=\"#777777\" text-anchor=\"") + anchor + "\"");
  };
  end(points.front().value, bar_left - 6.0, "end");
  end(points.back().value, bar_right + 6.0, "start");
  svg += text(bar_right + 62.0, middle + 4.5, range_text(row.found.answered), "font-size=\"13\" fill=\"#111111\"");
}

void draw_legend(std::string& svg) {
  const double y = 82.0, middle = y + 0.5 * bar_height;
  const auto words = [&](double x, const std::string& what) {
    svg += text(x, middle + 4.5, what, "font-size=\"12\" fill=\"#333333\"");
  };
  svg += rectangle(40.0, 66.0, y, bar_height, std::string("fill=\"") + answered_color + "\"");
  words(72.0, "answered rightly");
  svg += rectangle(192.0, 218.0, y, bar_height, "fill=\"url(#refused)\"");
  svg += "<circle cx=\"205\" cy=\"" + svg_number(middle) + "\" r=\"3\" fill=\"white\" stroke=\"#444444\"/>\n";
  words(224.0, "refused in words, or not converged and said so");
  svg += cross(534.0, middle, 4.5);
  words(546.0, "fails");
  svg += rectangle(596.0, 622.0, y, bar_height, std::string("fill=\"white\" stroke=\"") + outline_color + "\"");
  words(628.0, "tried, logarithmic, each axis by itself");
  svg += "<path d=\"M882 " + svg_number(middle - 3.0) + "h8l-4 5z\" fill=\"#222222\"/>\n";
  words(896.0, "usual value");
  svg += text(bar_right + 62.0, middle + 4.5, "answered", "font-size=\"12\" fill=\"#333333\" font-weight=\"bold\"");
}

}  // namespace

std::string range_text(const std::optional<AtlasRange>& range) {
  return range ? brief_number(range->low) + " to " + brief_number(range->high) : "none";
}

std::string brief_number(double value) {
  std::string text = svg_number(value, "%.3g");
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  const bool negative = text[e + 1] == '-';
  std::size_t digits = e + 2;
  while (digits + 1 < text.size() && text[digits] == '0') ++digits;
  return text.substr(0, e + 1) + (negative ? "-" : "") + text.substr(digits);
}

std::string safe_box_svg(const std::vector<SafeBoxRow>& rows, const std::string& note) {
  std::string body;
  double y = top;
  std::string group;
  for (const SafeBoxRow& row : rows) {
    if (row.axis->group != group) {
      group = row.axis->group;
      y += group_height;
      body += text(20.0, y - 10.0, group, "font-size=\"15\" font-weight=\"bold\" fill=\"#111111\"");
    }
    draw_row(row, y, body);
    y += row_height;
  }
  std::string svg = svg_begin(width, static_cast<int>(y) + 20);
  svg +=
      "<defs><pattern id=\"refused\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" "
      "patternTransform=\"rotate(45)\"><rect width=\"6\" height=\"6\" fill=\"#f3f3f3\"/><path d=\"M0 0v6\" "
      "stroke=\"#b9b9b9\" stroke-width=\"2\"/></pattern></defs>\n";
  svg += svg_heading("The box in which the simulation is sound", note);
  draw_legend(svg);
  return svg + body + "</svg>\n";
}

}  // namespace finegauge
