#include "benchmarks/measure/force_curves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace finegauge {
namespace {

constexpr double no_curve = std::numeric_limits<double>::quiet_NaN();

/// Linear interpolation; x ascending, at least two.
double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::upper_bound(x.begin() + 1, x.end() - 1, at);
  const std::size_t k = static_cast<std::size_t>(above - x.begin());
  const double width = x[k] - x[k - 1];
  return width > 0.0 ? y[k - 1] + (at - x[k - 1]) / width * (y[k] - y[k - 1]) : y[k];
}

/// The curve with the frames left out in which the tip did not get farther than ever before.
Envelope advancing_part(const ForceCurve& curve) {
  Envelope part;
  for (std::size_t k = 0; k < curve.travel.size(); ++k) {
    if (!part.travel.empty() && !(curve.travel[k] > part.travel.back())) continue;
    part.travel.push_back(curve.travel[k]);
    part.force.push_back(curve.force[k]);
  }
  return part;
}

/// Mean squares of a - b and of b, at equally spaced places from `from` on that both cover.
struct MeanSquares {
  double difference = no_curve, size = no_curve;
};
MeanSquares mean_squares(const Envelope& a, const Envelope& b, double from, int samples) {
  if (a.travel.size() < 2 || b.travel.size() < 2) return {};
  const double first = std::max({from, a.travel.front(), b.travel.front()});
  const double last = std::min(a.travel.back(), b.travel.back());
  if (!(last > first)) return {};
  MeanSquares mean{0.0, 0.0};
  for (int k = 0; k < samples; ++k) {
    const double x = first + (last - first) * (k + 0.5) / samples;
    const double there = b.at(x), off = a.at(x) - there;
    mean.difference += off * off / samples;
    mean.size += there * there / samples;
  }
  return mean;
}

double distance(const Envelope& a, const Envelope& b, int samples) {
  const MeanSquares mean = mean_squares(a, b, -std::numeric_limits<double>::infinity(), samples);
  return mean.size > 0.0 ? std::sqrt(mean.difference / mean.size) : no_curve;
}

std::size_t deepest(const ForceCurve& curve) {
  return static_cast<std::size_t>(std::ranges::max_element(curve.travel) - curve.travel.begin());
}

}  // namespace

double Envelope::at(double x) const { return interpolate(travel, force, x); }

double stiffness_before_puncture(const ForceCurve& curve) {
  if (curve.puncture < 0) return no_curve;
  const double peak = curve.force[curve.puncture];
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (int k = 0; k <= curve.puncture; ++k) {
    if (curve.force[k] < 0.2 * peak || curve.force[k] > 0.8 * peak) continue;
    n += 1.0;
    x += curve.travel[k];
    y += curve.force[k];
    xx += curve.travel[k] * curve.travel[k];
    xy += curve.travel[k] * curve.force[k];
  }
  const double spread = n * xx - x * x;
  return n >= 3.0 && spread > 0.0 ? (n * xy - x * y) / spread : no_curve;
}

ForcePeak passing_point(double margin_before, ForcePeak before, double margin_after, ForcePeak after) {
  if (!(margin_before < 0.0 && margin_after >= 0.0)) return after;
  const double share = margin_before / (margin_before - margin_after);
  return {before.travel + share * (after.travel - before.travel), before.force + share * (after.force - before.force)};
}

Envelope upper_envelope(const ForceCurve& curve) {
  Envelope envelope;
  for (const ForcePeak& peak : curve.peaks) {
    if (!envelope.travel.empty() && !(peak.travel > envelope.travel.back())) continue;
    envelope.travel.push_back(peak.travel);
    envelope.force.push_back(peak.force);
  }
  return envelope;
}

double envelope_distance(const ForceCurve& a, const ForceCurve& b, int samples) {
  return distance(upper_envelope(a), upper_envelope(b), samples);
}

double rms_distance(const ForceCurve& a, const ForceCurve& b, int samples) {
  return distance(advancing_part(a), advancing_part(b), samples);
}

double force_difference(const ForceCurve& a, const ForceCurve& b, int samples) {
  return std::sqrt(mean_squares({a.travel, a.force}, {b.travel, b.force}, 0.0, samples).difference);
}

ForceCurve way_in(const ForceCurve& curve) {
  ForceCurve in;
  const std::size_t last = deepest(curve);
  for (std::size_t k = 0; k < curve.travel.size() && k <= last; ++k) {
    in.travel.push_back(curve.travel[k]);
    in.force.push_back(curve.force[k]);
  }
  return in;
}

ForceCurve way_back(const ForceCurve& curve) {
  ForceCurve back;
  const std::size_t first = deepest(curve);
  for (std::size_t k = curve.travel.size(); k > first; --k) {
    back.travel.push_back(curve.travel[k - 1]);
    back.force.push_back(curve.force[k - 1]);
  }
  return back;
}

double loop_area(const ForceCurve& curve) {
  double area = 0.0;
  for (std::size_t k = 1; k < curve.travel.size(); ++k)
    area += 0.5 * (curve.force[k] + curve.force[k - 1]) * (curve.travel[k] - curve.travel[k - 1]);
  return area;
}

}  // namespace finegauge
