#include "benchmarks/gate/time_runs.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "benchmarks/program/interrupt.hpp"

namespace finegauge {
namespace {

constexpr int calibrated_runs = 5;
constexpr int kernel_frames = 60;  // a tenth of a second

/// The columns of frame times of a result; a reason where one is missing.
std::string take_columns(const JobResult& job, const std::set<std::string>& columns,
                         std::map<std::string, RunTimes>& times) {
  if (!job.document) return job.failure;
  const Json& rows = job.document->at("rows");
  for (const std::string& column : columns) {
    RunTimes& of_column = times[column];
    for (const Json& row : rows) {
      if (!row.contains(column) || !row.at(column).is_number()) return "a row of the result has no number " + column;
      of_column.push_back(row.at(column).get<double>());
      if (!(of_column.back() > 0.0)) return "a frame whose " + column + " is not above zero";
    }
    if (of_column.empty()) return "no frames: the result has no rows";
  }
  return {};
}

/// What is under way for one command.
class Timing {
 public:
  Timing(const JobWords& command, std::span<const Budget> budgets, JobRunner& runner, CalibrationKernel& kernel)
      : command_(command), runner_(runner), kernel_(kernel) {
    for (const Budget& budget : budgets) {
      columns_.insert(budget.frames);
      calibrated_ = calibrated_ || !budget.against_base;
    }
  }

  /// One run of the head with the kernel before and after it.
  std::string run_head(TimeRuns& runs, std::map<std::string, RunTimes>& times) {
    const KernelTime before = calibrated_ ? kernel_.measure(kernel_frames) : KernelTime{};
    const std::string failure = take_columns(runner_.run(JobRunner::this_program(), command_), columns_, times);
    if (!failure.empty() || !calibrated_) return failure;
    const KernelTime after = kernel_.measure(kernel_frames);
    for (const auto& [column, frames] : times) {
      const double kernel_ms = column == processor_column ? std::sqrt(before.processor_ms * after.processor_ms)
                                                          : std::sqrt(before.wall_ms * after.wall_ms);
      runs.calibrated[column].push_back({frames, kernel_ms});
    }
    return {};
  }
  std::string run_base(const std::filesystem::path& base, std::map<std::string, RunTimes>& times) {
    return take_columns(runner_.run(base, command_), columns_, times);
  }

 private:
  const JobWords& command_;
  JobRunner& runner_;
  CalibrationKernel& kernel_;
  std::set<std::string> columns_;
  bool calibrated_ = false;
};

bool any_wants_more(std::span<const Budget> budgets, const TimeRuns& runs) {
  return std::ranges::any_of(budgets, [&](const Budget& budget) {
    if (!budget.against_base) return false;
    const auto found = runs.blocks.find(budget.frames);
    const ComparisonRule rule = rule_of(budget);
    return found == runs.blocks.end() || wants_more_blocks(compare_frames(found->second, rule), rule);
  });
}

}  // namespace

ComparisonRule rule_of(const Budget& budget) {
  ComparisonRule rule;
  rule.percentile = budget.percentile;
  rule.slower = budget.slower;
  return rule;
}

TimeRuns run_for_times(const JobWords& command, std::span<const Budget> budgets,
                       const std::optional<std::filesystem::path>& base, JobRunner& runner, CalibrationKernel& kernel,
                       std::mt19937& random, const std::function<void(const std::string&)>& tell) {
  TimeRuns runs;
  Timing timing(command, budgets, runner, kernel);
  tell(to_string(command));
  runs.first = runner.run(JobRunner::this_program(), command);
  runs.failure = runs.first.failure;
  const bool compared = base && std::ranges::any_of(budgets, &Budget::against_base);
  if (compared) {
    const JobResult first_of_base = runner.run(*base, command);
    if (!first_of_base.document) runs.base_failure = "the base: " + first_of_base.failure;
  }
  const bool calibrated = !std::ranges::all_of(budgets, &Budget::against_base);
  const auto stop = [&] { return !runs.failure.empty() || interrupt_signal() != 0; };

  for (int block = 0; compared && runs.base_failure.empty() && !stop() && any_wants_more(budgets, runs); ++block) {
    tell(to_string(command) + ", block " + std::to_string(block + 1));
    std::map<std::string, RunTimes> head, of_base;
    const bool head_first = std::uniform_int_distribution<int>(0, 1)(random) == 0;
    if (head_first) runs.failure = timing.run_head(runs, head);
    runs.base_failure = timing.run_base(*base, of_base);
    if (!head_first) runs.failure = timing.run_head(runs, head);
    if (!runs.base_failure.empty()) runs.base_failure = "the base: " + runs.base_failure;
    if (!runs.failure.empty() || !runs.base_failure.empty()) break;
    for (auto& [column, frames] : head) runs.blocks[column].push_back({std::move(frames), std::move(of_base[column])});
  }
  for (int run = runs.calibrated.empty() ? 0 : calibrated_runs; calibrated && run < calibrated_runs && !stop(); ++run) {
    tell(to_string(command) + ", run " + std::to_string(run + 1) + " of " + std::to_string(calibrated_runs));
    std::map<std::string, RunTimes> frames;
    runs.failure = timing.run_head(runs, frames);
  }
  return runs;
}

}  // namespace finegauge
