#pragma once

#include <optional>
#include <string>
#include <vector>

#include "benchmarks/paper/phantom_comparison.hpp"
#include "benchmarks/program/plots.hpp"

namespace finegauge {

/// The paper's words and numbers beside ours, each with the reason why they differ. Without `plain`: it was not run.
std::vector<ComparisonRow> phantom_table(const std::vector<PhantomComparison>& comparisons, const PhantomRates& best,
                                         const std::optional<PhantomRates>& plain, const PaperNumbers& paper);

Plot phantom_force_plot(const PhantomComparison& comparison);
Plot phantom_dofs_plot(const std::vector<PhantomComparison>& comparisons);

/// Three digits, or "-" where there is no number.
std::string short_number(double value, const char* format = "%.3g");

}  // namespace finegauge
