#include "benchmarks/paper/lshape_sequences.hpp"

#include <algorithm>

#include "benchmarks/program/plots.hpp"

namespace finegauge {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

LshapeCrossing find_crossing(const LshapeSequences& study, LshapeScheme scheme, const LshapeError& error,
                             double target) {
  const auto& steps = study.sequences.at(scheme);
  double all = steps.empty() ? 0.0 : steps[0].total_ms();
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const LshapeStep &a = steps[i - 1], &b = steps[i];
    const double ea = error(a), eb = error(b);
    if (!(ea > target && eb <= target)) {
      all += b.total_ms();
      continue;
    }
    const double w = std::log(ea / target) / std::log(ea / eb);
    const auto between = [&](double x, double y) { return std::exp((1.0 - w) * std::log(x) + w * std::log(y)); };
    const double step_ms = between(a.total_ms(), b.total_ms());
    // Of a uniform sequence only the mesh itself is paid; of the others every mesh on the way.
    return {between(a.dofs, b.dofs),
            between(a.topology_ms + a.mark_ms, b.topology_ms + b.mark_ms),
            between(a.assemble_ms + a.reduce_ms + a.solve_ms, b.assemble_ms + b.reduce_ms + b.solve_ms),
            step_ms,
            scheme == LshapeScheme::uniform ? step_ms : all + step_ms,
            between(a.eta, b.eta),
            between(study.true_error(a), study.true_error(b)),
            between(study.effectivity(a), study.effectivity(b))};
  }
  return {};
}

double error_slope(const LshapeSequences& study, LshapeScheme scheme, const LshapeError& error) {
  PlotSeries series;
  for (const LshapeStep& step : study.sequences.at(scheme)) {
    series.x.push_back(step.dofs);
    series.y.push_back(error(step));
    if (step.dofs >= 40000) break;
  }
  return -logarithmic_slope(series);
}

void take_median_times(const std::vector<std::vector<LshapeStep>>& passes, std::vector<LshapeStep>& steps) {
  const auto median = [&](std::size_t i, double LshapeStep::*stage) {
    std::vector<double> times;
    for (const auto& pass : passes) times.push_back(pass[i].*stage);
    std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
    return times[times.size() / 2];
  };
  steps = passes.front();
  for (std::size_t i = 0; i < steps.size(); ++i)
    for (double LshapeStep::*const stage : {&LshapeStep::estimate_ms, &LshapeStep::mark_ms, &LshapeStep::topology_ms,
                                            &LshapeStep::assemble_ms, &LshapeStep::reduce_ms, &LshapeStep::solve_ms})
      steps[i].*stage = median(i, stage);
}

double uniform_true_error(const LshapeSequences& study, int dofs) {
  for (const LshapeStep& step : study.sequences.at(LshapeScheme::uniform))
    if (step.dofs == dofs) return study.true_error(step);
  return nan;
}

double eta_at(const std::vector<LshapeStep>& steps, double dofs) {
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const LshapeStep &a = steps[i - 1], &b = steps[i];
    if (a.dofs > dofs || b.dofs < dofs) continue;
    const double w = std::log(dofs / a.dofs) / std::log(static_cast<double>(b.dofs) / a.dofs);
    return std::exp((1.0 - w) * std::log(a.eta) + w * std::log(b.eta));
  }
  return nan;
}

}  // namespace finegauge
