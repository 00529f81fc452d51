#include "benchmarks/report/chart_text.hpp"

#include <cstdio>

#include "benchmarks/report/html.hpp"

namespace finegauge {

std::string pixels(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  std::string out = text;
  if (out.ends_with(".0")) out.resize(out.size() - 2);
  return out == "-0" ? "0" : out;
}

std::string chart_text(double x, double y, const std::string& style, const std::string& words) {
  return "<text x=\"" + pixels(x) + "\" y=\"" + pixels(y) + "\" class=\"" + style + "\">" + html_escaped(words) +
         "</text>";
}

}  // namespace finegauge
