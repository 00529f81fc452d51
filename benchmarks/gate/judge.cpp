#include "benchmarks/gate/judge.hpp"

#include <cmath>
#include <cstdio>

#include "benchmarks/gate/result_path.hpp"

namespace finegauge {
namespace {

std::string text(const char* format, double a, double b = 0.0, double c = 0.0) {
  char line[200];
  std::snprintf(line, sizeof line, format, a, b, c);
  return line;
}

Judgement begin(const Budget& budget, const char* judged) {
  Judgement judgement;
  judgement.name = budget.name;
  judgement.kind = to_string(budget.kind);
  judgement.run = to_string(budget.run);
  judgement.low = budget.low;
  judgement.high = budget.high;
  judgement.reason = budget.reason;
  judgement.judged = judged;
  return judgement;
}

void judge_band(Judgement& judgement, double value) {
  judgement.value = value;
  judgement.ok = value >= judgement.low && value <= judgement.high;
}

Judgement judge_against_base(const Budget& budget, const TimeRuns& runs) {
  Judgement judgement = begin(budget, "interleaved A/B");
  const auto found = runs.blocks.find(budget.frames);
  if (!runs.base_failure.empty() || found == runs.blocks.end()) {
    judgement.why = runs.base_failure.empty() ? "no block was run" : runs.base_failure;
    return judgement;
  }
  const ComparisonRule rule = rule_of(budget);
  const FrameComparison comparison = compare_frames(found->second, rule);
  judgement.ok = !comparison.alarm && comparison.decided;
  judgement.details = {{"percentile", budget.percentile},   {"blocks", comparison.blocks},
                       {"ratio", comparison.ratio},         {"ratio_low", comparison.low},
                       {"ratio_high", comparison.high},     {"p_value", comparison.p_value},
                       {"significance", rule.significance}, {"frame_by_frame", comparison.frame_by_frame}};
  if (comparison.decided) judgement.value = comparison.ratio;
  if (comparison.alarm)
    judgement.why = text("slower than the base by %.1f %% (%.1f to %.1f %%)", 100.0 * (comparison.ratio - 1.0),
                         100.0 * (comparison.low - 1.0), 100.0 * (comparison.high - 1.0)) +
                    text(", p = %.2g", comparison.p_value);
  if (!comparison.decided)
    judgement.why = text("undecided: the machine is so noisy that the ratio lies anywhere from %.2f to %.2f",
                         comparison.low, comparison.high);
  return judgement;
}

Judgement judge_calibrated(const Budget& budget, const TimeRuns& runs) {
  Judgement judgement = begin(budget, "calibrated");
  const auto found = runs.calibrated.find(budget.frames);
  if (found == runs.calibrated.end()) {
    judgement.why = "no run was timed";
    return judgement;
  }
  const CalibratedTime time = calibrated_time(found->second, budget.percentile);
  judge_band(judgement, time.ratio);
  std::vector<double> kernel;
  for (const CalibratedRun& run : found->second) kernel.push_back(run.kernel_ms);
  judgement.details = {{"percentile", budget.percentile},
                       {"runs", found->second.size()},
                       {"ratio_low", time.low},
                       {"ratio_high", time.high},
                       {"kernel_ms", median(kernel)}};
  return judgement;
}

}  // namespace

Judgement not_compared(const Budget& budget, bool allowed, const std::string& why) {
  Judgement judgement = begin(budget, allowed ? "skipped" : "not compared");
  judgement.ok = judgement.skipped = allowed;
  judgement.why = why;
  return judgement;
}

Judgement judge_number(const Budget& budget, const JobResult& job) {
  const bool exact = budget.kind == BudgetKind::counter && budget.low == budget.high;
  Judgement judgement = begin(budget, exact ? "exact" : "band");
  judgement.details = {{"path", budget.value}};
  if (!job.document) {
    judgement.why = job.failure;
    return judgement;
  }
  const FoundNumber found = find_number(*job.document, budget.value);
  if (!found.value || !std::isfinite(*found.value)) {
    judgement.why = found.value ? "the value is not finite" : found.why;
    return judgement;
  }
  judge_band(judgement, *found.value);
  if (budget.kind == BudgetKind::counter && *found.value != std::floor(*found.value)) {
    judgement.ok = false;
    judgement.why = "a counter counts in whole numbers";
  }
  return judgement;
}

Judgement judge_instructions(const Budget& budget, const CountedInstructions& head, const CountedInstructions& other) {
  for (const CountedInstructions* counted : {&head, &other})
    if (!counted->count) return not_compared(budget, counted->uncountable && budget.without_valgrind, counted->failure);
  Judgement judgement = begin(budget, "band");
  judge_band(judgement, *head.count / *other.count);
  judgement.details = {{"instructions", *head.count},
                       {"over", budget.over.empty() ? "base" : to_string(budget.over)},
                       {"instructions_over", *other.count}};
  if (!budget.within.empty()) judgement.details["within"] = budget.within;
  return judgement;
}

Judgement judge_time(const Budget& budget, const TimeRuns& runs) {
  Judgement judgement;
  if (!runs.failure.empty()) {
    judgement = begin(budget, budget.against_base ? "interleaved A/B" : "calibrated");
    judgement.why = runs.failure;
    return judgement;
  }
  judgement = budget.against_base ? judge_against_base(budget, runs) : judge_calibrated(budget, runs);
  // Told beside the verdict, never the verdict: a deadline is in milliseconds of a machine.
  const FoundNumber deadline = find_number(*runs.first.document, "summary.deadline_ms");
  const FoundNumber p99 = find_number(*runs.first.document, "summary.frame_ms.p99");
  if (deadline.value && p99.value) judgement.details["p99_over_deadline"] = *p99.value / *deadline.value;
  return judgement;
}

Json to_check(const Judgement& judgement) {
  Json check = {{"name", judgement.name}, {"value", judgement.value ? Json(*judgement.value) : Json(nullptr)},
                {"low", judgement.low},   {"high", judgement.high},
                {"ok", judgement.ok},     {"judged", judgement.judged}};
  if (judgement.skipped) check["skipped"] = true;
  if (!judgement.value) check["value_reason"] = judgement.why;
  if (!judgement.why.empty()) check["why"] = judgement.why;
  return check;
}

Json to_row(const Judgement& judgement) {
  Json row = to_check(judgement);
  row["kind"] = judgement.kind;
  row["run"] = judgement.run;
  row["reason"] = judgement.reason;
  for (const auto& [key, value] : judgement.details.items()) row[key] = value;
  return row;
}

}  // namespace finegauge
