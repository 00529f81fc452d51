#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/gate/budget.hpp"
#include "benchmarks/gate/calibration_kernel.hpp"
#include "benchmarks/gate/frame_comparison.hpp"
#include "benchmarks/gate/jobs.hpp"

namespace finegauge {

/// The column of a frame's processor time in the results of `finegauge run`; its yardstick is the kernel's.
inline constexpr const char* processor_column = "processor_ms";

/// The rule by which a budget of kind time against the base is judged.
ComparisonRule rule_of(const Budget& budget);

/// Repeated runs of one command, whose frame times the budgets on it judge.
struct TimeRuns {
  std::map<std::string, std::vector<TimeBlock>> blocks;          ///< by column of frames
  std::map<std::string, std::vector<CalibratedRun>> calibrated;  ///< likewise
  JobResult first;                                               ///< of the head build, not timed: its result is shared
  std::string failure, base_failure;  ///< why there are none; the base's concerns comparisons with it alone
};

/// Runs a command of both builds in blocks of one run each, the order within a block tossed, until none of the budgets
/// wants more; between them, where a budget is calibrated, the kernel. Without a base, and where none is compared with,
/// five calibrated runs. One run of each build goes before and is not timed: it finds files and memory cold.
TimeRuns run_for_times(const JobWords& command, std::span<const Budget> budgets,
                       const std::optional<std::filesystem::path>& base, JobRunner& runner, CalibrationKernel& kernel,
                       std::mt19937& random, const std::function<void(const std::string&)>& tell);

}  // namespace finegauge
