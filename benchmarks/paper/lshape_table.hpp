#pragma once

#include <vector>

#include "benchmarks/paper/direct_comparison.hpp"
#include "benchmarks/paper/lshape_findings.hpp"
#include "benchmarks/program/study.hpp"

namespace finegauge {

/// The paper's numbers beside ours, each with the reason why they differ. `energy_uncertainty`: of ∫ ε:σ of the exact
/// solution.
std::vector<ComparisonRow> lshape_table(const LshapeSequences& study, const LshapeFindings& findings,
                                        const DirectComparison& direct, const PaperNumbers& paper,
                                        double energy_uncertainty, bool quick);

/// A number in printf's format, "not reached" where there is none.
std::string number_text(const char* format, double value);

}  // namespace finegauge
