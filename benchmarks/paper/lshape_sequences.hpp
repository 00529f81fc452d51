#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <vector>

#include "benchmarks/paper/lshape_run.hpp"

namespace finegauge {

/// The three sequences of one or more passes, and what they share.
struct LshapeSequences {
  LshapeRunOptions options;
  double reference_energy =
      std::numeric_limits<double>::quiet_NaN();  ///< of the exact solution; not a number where it is not known
  std::map<LshapeScheme, std::vector<LshapeStep>> sequences;

  double true_error(const LshapeStep& step) const { return std::sqrt(1.0 - step.energy / reference_energy); }
  double effectivity(const LshapeStep& step) const {
    return step.estimated_error / std::sqrt(reference_energy - step.energy);
  }
};

using LshapeError = std::function<double(const LshapeStep&)>;

/// Where a sequence first has at most the given error: between two meshes, in logarithms.
struct LshapeCrossing {
  double dofs = std::numeric_limits<double>::quiet_NaN(), topology_ms = std::numeric_limits<double>::quiet_NaN(),
         solve_ms = std::numeric_limits<double>::quiet_NaN(), step_ms = std::numeric_limits<double>::quiet_NaN(),
         all_steps_ms = std::numeric_limits<double>::quiet_NaN();
  double eta = std::numeric_limits<double>::quiet_NaN(), true_error = std::numeric_limits<double>::quiet_NaN(),
         effectivity = std::numeric_limits<double>::quiet_NaN();
};
LshapeCrossing find_crossing(const LshapeSequences& study, LshapeScheme scheme, const LshapeError& error,
                             double target);

/// Positive: minus the least-squares slope of log error over log dofs, from the coarsest mesh to the first with 40,000
/// dofs or the last.
double error_slope(const LshapeSequences& study, LshapeScheme scheme, const LshapeError& error);

/// Median over the passes, stage by stage; all else is the same to the bit in every pass.
void take_median_times(const std::vector<std::vector<LshapeStep>>& passes, std::vector<LshapeStep>& steps);

/// The true error of the uniform mesh with the given dofs.
double uniform_true_error(const LshapeSequences& study, int dofs);

/// eta of a sequence at a count of dofs, between two meshes in logarithms.
double eta_at(const std::vector<LshapeStep>& steps, double dofs);

}  // namespace finegauge
