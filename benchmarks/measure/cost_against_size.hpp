#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace finegauge {

/// cost = factor × size^exponent.
struct PowerLaw {
  double factor = 0.0, exponent = 0.0;
  double exponent_error = 0.0;  ///< standard error of the exponent, from what the costs scatter about the law
  double r_squared = 0.0;       ///< share of the variance of log cost that the law explains; 1 where nothing varies
};
/// Least squares in the logarithms. None of fewer than three different sizes: two points lie on a line whatever they
/// are, and say nothing of how good it is. Throws std::invalid_argument where the lists differ in length or a value is
/// not positive and finite.
std::optional<PowerLaw> fit_power_law(std::span<const double> size, std::span<const double> cost);

/// A benchmark's result: a family's member at one size.
struct SizedResult {
  std::string family;  ///< FAMILY, or FAMILY/full beside FAMILY/WAY for other ways to the same error
  double size = 0.0;   ///< free degrees of freedom
  double time_ms = 0.0;
  struct Counter {
    std::string name;
    double value = 0.0;
  };
  std::vector<Counter> counters;
};

/// What two ways to one error cost there.
struct EqualErrorCost {
  double error = 0.0;  ///< the smallest that both ways reach
  double full_size = 0.0, full_ms = 0.0;
  double size = 0.0, time_ms = 0.0;
};
/// Between the results on both sides of the error, in logarithms; `full` and `way` ascending in size. None where one of
/// the two lacks the counter somewhere, or their errors do not overlap.
std::optional<EqualErrorCost> cost_at_equal_error(std::span<const SizedResult> full, std::span<const SizedResult> way,
                                                  const std::string& error_counter);

/// A block for each family with three sizes or more, in the order in which they came: the exponents of its processor
/// time and of its exact counters; a line for each way beside a full one and error that both know. Families with fewer
/// sizes are counted. Empty where there is no result.
std::string cost_against_size_table(const std::vector<SizedResult>& results);

}  // namespace finegauge
