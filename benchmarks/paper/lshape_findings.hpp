#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/paper/lshape_sequences.hpp"
#include "benchmarks/paper/paper_numbers.hpp"
#include "benchmarks/program/result_document.hpp"

namespace finegauge {

inline constexpr std::array lshape_schemes = {LshapeScheme::uniform, LshapeScheme::adaptive, LshapeScheme::directional};

/// An error at which the schemes are compared.
struct LshapeTarget {
  std::string key;
  LshapeError error;
  double value;
};

/// What the three sequences say. `targets` refer to the sequences that they were found from.
struct LshapeFindings {
  std::map<LshapeScheme, double> eta_slopes, true_slopes;
  std::vector<LshapeTarget> targets;  ///< equal_eta, equal_true_error, equal_true_error_316899
  std::map<std::string, std::map<LshapeScheme, LshapeCrossing>> crossings;  ///< by key of the target
};
LshapeFindings find_lshape_findings(const LshapeSequences& study, const PaperNumbers& paper);

/// slopes, table1, saving and true_error_targets of the study's summary; a number that is missing has its reason.
void add_to_summary(const LshapeFindings& findings, Json& summary);

/// Checks of the default problem, with bounds on both sides.
void add_lshape_checks(const LshapeSequences& study, const LshapeFindings& findings, bool quick, Json& checks);

}  // namespace finegauge
