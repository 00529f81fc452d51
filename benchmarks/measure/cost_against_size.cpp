#include "benchmarks/measure/cost_against_size.hpp"

#include <gsl/gsl_fit.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>
#include <stdexcept>
#include <string_view>

namespace finegauge {
namespace {

/// Of the benchmarks' counters those that a cost grows by, and errors. All others are sizes themselves, or settings.
constexpr std::array fitted_counters = {
    "blocks", "factor_nonzeros", "iterations", "linear_iterations", "solver_iterations", "uzawa_iterations",
    "eta",    "true_error"};
constexpr std::array error_counters = {"eta", "true_error"};

std::vector<double> logarithms(std::span<const double> values, const char* what) {
  std::vector<double> result;
  for (const double value : values) {
    if (!(value > 0.0 && std::isfinite(value)))
      throw std::invalid_argument(std::string(what) + ": found " + std::to_string(value) +
                                  ", allowed is positive and finite");
    result.push_back(std::log(value));
  }
  return result;
}

const double* find_counter(const SizedResult& result, std::string_view name) {
  for (const SizedResult::Counter& counter : result.counters)
    if (counter.name == name) return &counter.value;
  return nullptr;
}

/// The counter of each member; empty where one has none, or one that has no logarithm.
std::vector<double> counter_values(std::span<const SizedResult> family, std::string_view name) {
  std::vector<double> values;
  for (const SizedResult& result : family) {
    const double* const value = find_counter(result, name);
    if (!value || !(*value > 0.0 && std::isfinite(*value))) return {};
    values.push_back(*value);
  }
  return values;
}

struct SizeAndTime {
  double size, time_ms;
};
/// Where the errors, member by member, first have at most the one given.
std::optional<SizeAndTime> at_error(std::span<const SizedResult> way, std::span<const double> errors, double error) {
  for (std::size_t i = 0; i < way.size(); ++i) {
    if (errors[i] > error) continue;
    if (errors[i] == error) return SizeAndTime{way[i].size, way[i].time_ms};
    if (i == 0) return std::nullopt;
    const double w = std::log(errors[i - 1] / error) / std::log(errors[i - 1] / errors[i]);
    const auto between = [w](double a, double b) { return std::exp((1.0 - w) * std::log(a) + w * std::log(b)); };
    return SizeAndTime{between(way[i - 1].size, way[i].size), between(way[i - 1].time_ms, way[i].time_ms)};
  }
  return std::nullopt;
}

std::string formatted(const char* format, auto... values) {
  std::array<char, 200> text;
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

/// 41823 as 41,823.
std::string grouped(double value) {
  std::string digits = formatted("%.0f", value);
  for (int place = static_cast<int>(digits.size()) - 3; place > 0; place -= 3) digits.insert(place, ",");
  return digits;
}

std::string fit_line(const std::string& what, std::span<const double> sizes, std::span<const double> values) {
  const std::string range = formatted("  %-20s %10.4g to %-10.4g", what.c_str(), values.front(), values.back());
  if (std::ranges::all_of(values, [&](double value) { return value == values.front(); })) return range + " constant\n";
  const auto law = fit_power_law(sizes, values);
  return range + formatted(" %6.2f ± %-6.2f %6.3f\n", law->exponent, law->exponent_error, law->r_squared);
}

struct Family {
  std::string name;
  std::vector<SizedResult> members;  ///< ascending in size
  std::vector<double> sizes() const {
    std::vector<double> values;
    for (const SizedResult& member : members) values.push_back(member.size);
    return values;
  }
};

std::vector<Family> find_families(const std::vector<SizedResult>& results) {
  std::vector<Family> families;
  for (const SizedResult& result : results) {
    auto found = std::ranges::find(families, result.family, &Family::name);
    if (found == families.end()) found = families.insert(found, Family{result.family, {}});
    found->members.push_back(result);
  }
  for (Family& family : families) std::ranges::stable_sort(family.members, {}, &SizedResult::size);
  return families;
}

std::string family_block(const Family& family) {
  const std::vector<double> sizes = family.sizes();
  std::string text = family.name + ": " + std::to_string(std::set(sizes.begin(), sizes.end()).size()) + " sizes, " +
                     grouped(sizes.front()) + " to " + grouped(sizes.back()) + " free dofs\n";
  std::vector<double> times;
  for (const SizedResult& member : family.members) times.push_back(member.time_ms);
  text += fit_line("time [ms]", sizes, times);
  for (const char* const name : fitted_counters)
    if (const std::vector<double> values = counter_values(family.members, name); !values.empty())
      text += fit_line(name, sizes, values);
  return text;
}

/// FAMILY/full beside FAMILY/WAY.
std::string comparison_lines(const Family& full, const Family& way) {
  const std::string prefix = full.name.substr(0, full.name.rfind('/') + 1);
  if (&way == &full || !way.name.starts_with(prefix)) return {};
  std::string text;
  for (const char* const error : error_counters) {
    const auto cost = cost_at_equal_error(full.members, way.members, error);
    if (!cost) continue;
    text += formatted("%-34s %-10s %6.4f   ", way.name.c_str(), error, cost->error) +
            formatted("%6s dofs %8.3g ms   ", grouped(cost->size).c_str(), cost->time_ms) +
            formatted("%6s dofs %8.3g ms   ", grouped(cost->full_size).c_str(), cost->full_ms) +
            formatted("%5.2f dofs %5.2f time\n", cost->full_size / cost->size, cost->full_ms / cost->time_ms);
  }
  return text;
}

}  // namespace

std::optional<PowerLaw> fit_power_law(std::span<const double> size, std::span<const double> cost) {
  if (size.size() != cost.size())
    throw std::invalid_argument("a power law needs a cost for each size: found " + std::to_string(size.size()) +
                                " sizes and " + std::to_string(cost.size()) + " costs");
  const std::vector<double> x = logarithms(size, "size"), y = logarithms(cost, "cost");
  if (std::set(x.begin(), x.end()).size() < 3) return std::nullopt;
  double intercept, slope, cov00, cov01, cov11, residual;  // the covariances are scaled by residual / (n - 2)
  gsl_fit_linear(x.data(), 1, y.data(), 1, x.size(), &intercept, &slope, &cov00, &cov01, &cov11, &residual);
  double mean = 0.0, variation = 0.0;
  for (const double value : y) mean += value / static_cast<double>(y.size());
  for (const double value : y) variation += (value - mean) * (value - mean);
  return PowerLaw{std::exp(intercept), slope, std::sqrt(cov11), variation > 0.0 ? 1.0 - residual / variation : 1.0};
}

std::optional<EqualErrorCost> cost_at_equal_error(std::span<const SizedResult> full, std::span<const SizedResult> way,
                                                  const std::string& error_counter) {
  const std::vector<double> full_errors = counter_values(full, error_counter),
                            way_errors = counter_values(way, error_counter);
  if (full_errors.empty() || way_errors.empty()) return std::nullopt;
  const double error = std::max(*std::ranges::min_element(full_errors), *std::ranges::min_element(way_errors));
  const auto at_full = at_error(full, full_errors, error), at_way = at_error(way, way_errors, error);
  if (!at_full || !at_way) return std::nullopt;
  return EqualErrorCost{error, at_full->size, at_full->time_ms, at_way->size, at_way->time_ms};
}

std::string cost_against_size_table(const std::vector<SizedResult>& results) {
  const std::vector<Family> families = find_families(results);
  std::string text, comparisons;
  int too_few = 0;
  for (const Family& family : families) {
    const std::vector<double> sizes = family.sizes();
    if (std::set(sizes.begin(), sizes.end()).size() < 3)
      ++too_few;
    else
      text += family_block(family);
    if (family.name.ends_with("/full"))
      for (const Family& way : families) comparisons += comparison_lines(family, way);
  }
  if (!text.empty())
    text = "\nCost against size: c * free_dofs^p by least squares of the logarithms; processor time, exact counters\n" +
           formatted("  %-20s %24s %15s %8s\n", "", "from smallest to largest", "p ± its error", "R²") + text;
  if (too_few > 0) text += std::to_string(too_few) + " families with fewer than three sizes: no exponent\n";
  if (!comparisons.empty())
    text += "\nWhat one error costs: the smallest that both reach, between sizes in logarithms\n" +
            formatted("%-34s %-17s   %23s   %23s   %s\n", "", "at", "this way", "refined everywhere",
                      "everywhere over this way") +
            comparisons;
  return text;
}

}  // namespace finegauge
