#include "benchmarks/gate/gate.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "benchmarks/gate/calibration_kernel.hpp"
#include "benchmarks/gate/time_runs.hpp"
#include "benchmarks/program/interrupt.hpp"

namespace finegauge {
namespace {

constexpr double seconds_allowed = 900.0;  // of a job; under callgrind the longest take minutes

class Gate {
 public:
  Gate(std::span<const Budget> budgets, const GateOptions& options)
      : budgets_(budgets), options_(options), random_(options.seed), runner_(seconds_allowed) {
    std::set<std::tuple<bool, std::string, JobWords>> jobs;
    for (const Budget& budget : budgets)
      jobs.insert({budget.kind == BudgetKind::instructions, budget.within, budget.run});
    jobs_planned_ = jobs.size();
  }

  GateResult run() {
    GateResult result;
    for (const Budget& budget : budgets_) {
      std::optional<Judgement> judgement = judge(budget);
      if (interrupt_signal() != 0) break;  // a child that was ended for it judges nothing
      result.judgements.push_back(std::move(*judgement));
    }
    result.jobs = std::move(jobs_);
    return result;
  }

 private:
  Judgement judge(const Budget& budget) {
    if (options_.quick && (budget.slow || budget.kind == BudgetKind::instructions))
      return not_compared(budget, true, "left out by --quick");
    if (budget.needs_base() && !options_.base)
      return not_compared(budget, budget.without_base, "no base build was given (--base)");
    switch (budget.kind) {
      case BudgetKind::accuracy:
      case BudgetKind::counter:
        return judge_number(budget, result_of(budget.run));
      case BudgetKind::instructions:
        return judge_instructions(budget, instructions_of(JobRunner::this_program(), budget.run, budget.within),
                                  budget.over.empty()
                                      ? instructions_of(*options_.base, budget.run, budget.within)
                                      : instructions_of(JobRunner::this_program(), budget.over, budget.within));
      case BudgetKind::time:
        return judge_time(budget, times_of(budget.run));
    }
    return {};
  }

  /// All commands that are timed are timed before anything reads their results, so that none is run twice for it.
  const JobResult& result_of(const JobWords& words) {
    if (const auto found = results_.find(words); found != results_.end()) return found->second;
    if (!of_time(words).empty()) return times_of(words).first;
    tell(to_string(words));
    JobResult& job = results_[words];
    job = runner_.run(JobRunner::this_program(), words);
    jobs_.push_back({to_string(words), job.exit_code, job.seconds});
    return job;
  }

  const CountedInstructions& instructions_of(const std::filesystem::path& program, const JobWords& words,
                                             const std::string& within) {
    const std::tuple<std::string, JobWords, std::string> key{program.string(), words, within};
    if (const auto found = counted_.find(key); found != counted_.end()) return found->second;
    tell("instructions of " + to_string(words));
    return counted_[key] = runner_.count_instructions(program, words, within);
  }

  /// The budgets on the frame times of a command that can be judged in this run.
  std::vector<Budget> of_time(const JobWords& words) const {
    std::vector<Budget> found;
    for (const Budget& budget : budgets_)
      if (budget.kind == BudgetKind::time && budget.run == words && !(budget.needs_base() && !options_.base) &&
          !(options_.quick && budget.slow))
        found.push_back(budget);
    return found;
  }

  const TimeRuns& times_of(const JobWords& words) {
    if (const auto found = times_.find(words); found != times_.end()) return found->second;
    if (!kernel_) kernel_.emplace();
    TimeRuns& runs = times_[words];
    runs = run_for_times(words, of_time(words), options_.base, runner_, *kernel_, random_,
                         [&](const std::string& doing) { options_.progress(fraction(), doing); });
    ++jobs_done_;
    jobs_.push_back({to_string(words), runs.first.exit_code, runs.first.seconds});
    return runs;
  }

  double fraction() const {
    return jobs_planned_ == 0 ? 1.0
                              : std::min(1.0, static_cast<double>(jobs_done_) / static_cast<double>(jobs_planned_));
  }
  void tell(const std::string& doing) {
    options_.progress(fraction(), doing);
    ++jobs_done_;
  }

  std::span<const Budget> budgets_;
  const GateOptions& options_;
  std::mt19937 random_;
  JobRunner runner_;
  std::optional<CalibrationKernel> kernel_;
  std::map<JobWords, JobResult> results_;
  std::map<JobWords, TimeRuns> times_;
  std::map<std::tuple<std::string, JobWords, std::string>, CountedInstructions> counted_;
  std::vector<GateJob> jobs_;
  std::size_t jobs_planned_ = 0, jobs_done_ = 0;
};

}  // namespace

GateResult run_gate(std::span<const Budget> budgets, const GateOptions& options) {
  return Gate(budgets, options).run();
}

}  // namespace finegauge
