#include "benchmarks/measure/run_curves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "benchmarks/measure/force_curves.hpp"

namespace finegauge {
namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

/// Value `component` of a quantity of `width` components, linear in time between frames.
double value_at(const RunCurves& curves, const std::vector<double>& values, int width, int component, double time) {
  const auto after = std::ranges::lower_bound(curves.time, time);
  const auto value = [&](std::ptrdiff_t frame) { return values[static_cast<std::size_t>(width * frame + component)]; };
  const std::ptrdiff_t k = after - curves.time.begin();
  if (after == curves.time.end()) return value(k - 1);
  if (k == 0 || *after == time) return value(k);
  const double share = (time - *(after - 1)) / (*after - *(after - 1));
  return value(k - 1) + share * (value(k) - value(k - 1));
}

double mean_square_error(const RunCurves& reference, const RunCurves& curves, const std::string& name) {
  const auto found = curves.values.find(name), exact = reference.values.find(name);
  if (found == curves.values.end() || exact == reference.values.end() || curves.time.empty() || reference.time.empty())
    return no_value;
  const int width = static_cast<int>(found->second.size() / curves.time.size());
  double difference = 0.0, size = 0.0;
  // A longer time step ends later than the duration: there the reference has nothing to say.
  constexpr double slack = 1e-9;
  const double last = reference.time.back() * (1.0 + slack);
  for (std::size_t frame = 0; frame < curves.time.size() && curves.time[frame] <= last; ++frame)
    for (int c = 0; c < width; ++c) {
      const double there = value_at(reference, exact->second, width, c, curves.time[frame]);
      const double off = found->second[frame * static_cast<std::size_t>(width) + static_cast<std::size_t>(c)] - there;
      difference += off * off;
      size += there * there;
    }
  return size > 0.0 ? std::sqrt(difference / size) : no_value;
}

ForceCurve curve_in(const RunCurves& curves, const std::vector<double>& force) {
  ForceCurve curve;
  curve.travel = curves.travel;
  curve.force = force;
  return way_in(curve);
}

/// ∫ F dx from touch to `last`, by the trapezoidal rule.
double work(const ForceCurve& curve, double last) {
  double sum = 0.0;
  for (std::size_t k = 1; k < curve.travel.size(); ++k) {
    const double from = std::clamp(curve.travel[k - 1], 0.0, last), to = std::clamp(curve.travel[k], 0.0, last);
    sum += 0.5 * (curve.force[k] + curve.force[k - 1]) * (to - from);
  }
  return sum;
}

double work_error(const RunCurves& reference, const RunCurves& curves) {
  if (curves.travel.empty() || reference.travel.empty()) return no_value;
  const ForceCurve exact = curve_in(reference, reference.tip_force), found = curve_in(curves, curves.tip_force);
  const double last = std::min(exact.travel.back(), found.travel.back());
  const double size = work(exact, last);
  return size > 0.0 ? std::abs(work(found, last) - size) / size : no_value;
}

}  // namespace

void RunCurves::add(double frame_time, const Json& quantities) {
  time.push_back(frame_time);
  for (const auto& [name, value] : quantities.items()) {
    std::vector<double>& list = values[name];
    if (value.is_array())
      for (const Json& component : value) list.push_back(component.get<double>());
    else
      list.push_back(value.get<double>());
  }
}

Json to_json(const RunCurves& curves) {
  return {{"time", curves.time},
          {"travel", curves.travel},
          {"force", curves.force},
          {"tip_force", curves.tip_force},
          {"values", curves.values}};
}

RunCurves run_curves(const Json& json) {
  RunCurves curves;
  json.at("time").get_to(curves.time);
  json.at("travel").get_to(curves.travel);
  json.at("force").get_to(curves.force);
  json.at("tip_force").get_to(curves.tip_force);
  json.at("values").get_to(curves.values);
  return curves;
}

std::map<std::string, double> errors_against(const RunCurves& reference, const RunCurves& curves,
                                             const std::vector<QuantityOfInterest>& quantities) {
  std::map<std::string, double> errors;
  for (const QuantityOfInterest& quantity : quantities) {
    double error = no_value;
    switch (quantity.kind) {
      case QuantityKind::energy:
      case QuantityKind::displacement:
        error = mean_square_error(reference, curves, quantity.name);
        break;
      case QuantityKind::force_curve:
        if (!curves.travel.empty() && !reference.travel.empty())
          error = rms_distance(curve_in(curves, curves.force), curve_in(reference, reference.force));
        break;
      case QuantityKind::tip_force:
        error = work_error(reference, curves);
        break;
    }
    errors[quantity.name] = error;
  }
  return errors;
}

}  // namespace finegauge
