#pragma once

#include <optional>
#include <string>
#include <vector>

#include "benchmarks/paper/paper_numbers.hpp"
#include "benchmarks/paper/tjunctions_cases.hpp"
#include "benchmarks/paper/tjunctions_crossover.hpp"
#include "benchmarks/program/study.hpp"

namespace finegauge {

/// Everything that the study found.
struct TjunctionFindings {
  std::vector<TjunctionCaseResult> cases;
  std::vector<ConformingCube> conforming;
  std::vector<EqualError> equal_error;  ///< adaptive, then directional
  Json phantom = Json::object();        ///< overhead_summary of the frames
  double phantom_share = 0.0;

  /// Cases of a sweep and a pattern, in the order in which they ran.
  std::vector<const TjunctionCaseResult*> sweep(const std::string& name, MarkingPattern pattern) const;
  std::optional<Crossover> crossover(LshapeScheme scheme, double (EqualError::*gain)() const) const;
  /// Of the cubes of sweep `share`; none where it never comes to that.
  std::optional<double> costs_the_whole(MarkingPattern pattern) const;
};

std::vector<ComparisonRow> tjunctions_table(const TjunctionFindings& findings, const PaperNumbers& paper);
std::vector<Plot> tjunctions_plots(const TjunctionFindings& findings, const PaperNumbers& paper);
Json tjunctions_summary(const TjunctionFindings& findings);
/// With bounds on both sides.
void add_tjunctions_checks(const TjunctionFindings& findings, Json& checks);

}  // namespace finegauge
