#include "benchmarks/report/chart_axis.hpp"

#include <algorithm>
#include <cmath>

#include "benchmarks/report/html.hpp"

namespace finegauge {

bool ChartAxis::takes(double value) const { return std::isfinite(value) && (!logarithmic || value > 0.0); }

void ChartAxis::include(double value) {
  if (takes(value)) low = std::min(low, value), high = std::max(high, value);
}

void ChartAxis::widen(double share) {
  if (!(low <= high)) low = high = 1.0;
  double a = logarithmic ? std::log10(low) : low, b = logarithmic ? std::log10(high) : high;
  if (!(b - a > 1e-9 * std::max({std::abs(a), std::abs(b), 1e-300}))) {
    const double half = logarithmic ? 0.3 : std::max(0.5 * std::abs(a), 0.5);
    a -= half, b += half;
  }
  const double room = share * (b - a);
  a -= room, b += room;
  low = logarithmic ? std::pow(10.0, a) : a, high = logarithmic ? std::pow(10.0, b) : b;
}

double ChartAxis::pixel(double value) const {
  const auto scale = [&](double v) { return logarithmic ? std::log10(v) : v; };
  return from_px + (to_px - from_px) * (scale(value) - scale(low)) / (scale(high) - scale(low));
}

std::vector<double> ChartAxis::ticks(int wanted) const {
  std::vector<double> found;
  const double decades = logarithmic ? std::log10(high / low) : 0.0;
  if (logarithmic && decades > 0.8) {
    const int first = static_cast<int>(std::floor(std::log10(low))),
              last = static_cast<int>(std::ceil(std::log10(high)));
    const int stride = std::max(1, static_cast<int>(std::ceil(decades / wanted)));
    std::vector<int> steps = {1};
    if (3.0 * decades <= wanted + 2)
      steps = {1, 2, 5};
    else if (2.0 * decades <= wanted + 1)
      steps = {1, 3};
    for (int e = first; e <= last; ++e) {
      if (e % stride != 0) continue;
      for (const int step : steps)
        if (const double at = step * std::pow(10.0, e); at >= low * (1 - 1e-12) && at <= high * (1 + 1e-12))
          found.push_back(at);
    }
    return found;
  }
  // Over so short a part of a decade a linear division is as good.
  const double wish = (high - low) / wanted, digit = std::pow(10.0, std::floor(std::log10(wish)));
  const double step = digit * (wish <= 1.0001 * digit   ? 1.0
                               : wish <= 2.0001 * digit ? 2.0
                               : wish <= 5.0001 * digit ? 5.0
                                                        : 10.0);
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k)
    found.push_back(k == 0.0 ? 0.0 : k * step);
  return found;
}

std::vector<std::string> tick_labels(const std::vector<double>& ticks) {
  double largest = 0.0;
  for (const double tick : ticks) largest = std::max(largest, std::abs(tick));
  std::vector<std::string> labels;
  // What is left of a zero that was found by adding is none.
  for (const double tick : ticks) labels.push_back(bound_text(std::abs(tick) < 1e-12 * largest ? 0.0 : tick, 6));
  return labels;
}

}  // namespace finegauge
