#pragma once

#include <optional>
#include <string>

#include "benchmarks/gate/budget.hpp"
#include "benchmarks/gate/frame_comparison.hpp"
#include "benchmarks/gate/jobs.hpp"
#include "benchmarks/gate/time_runs.hpp"
#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// A budget's verdict. Without a value nothing was compared: that fails, unless the budget allows to skip it.
struct Judgement {
  std::string name, kind, run;
  std::optional<double> value;
  double low = 0.0, high = 0.0;
  bool ok = false, skipped = false;
  std::string judged;             ///< exact, band, interleaved A/B, calibrated, skipped
  std::string why;                ///< of a failure or a skip; else empty
  std::string reason;             ///< of the bounds
  Json details = Json::object();  ///< of the comparison
};

/// Of an accuracy or a counter budget: from the result of its command. A counter that is no whole number fails.
Judgement judge_number(const Budget& budget, const JobResult& job);
/// The head's count over that of the base or of the other command.
Judgement judge_instructions(const Budget& budget, const CountedInstructions& head, const CountedInstructions& other);
/// Of a time budget.
Judgement judge_time(const Budget& budget, const TimeRuns& runs);
/// Of one that could not be compared for a reason that it may or may not allow.
Judgement not_compared(const Budget& budget, bool allowed, const std::string& why);

/// As it stands in the result: name, value, low, high, ok and how it was judged; `skipped` or `why` where there is one.
Json to_check(const Judgement& judgement);
/// With all that is known of it.
Json to_row(const Judgement& judgement);

}  // namespace finegauge
