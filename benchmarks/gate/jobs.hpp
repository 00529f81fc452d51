#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "benchmarks/gate/budget.hpp"
#include "benchmarks/gate/child_process.hpp"
#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// What a command of a program left: its result document, or why there is none.
struct JobResult {
  std::optional<Json> document;  ///< of a job that ended with exit code 0 or 1
  int exit_code = -1;
  double seconds = 0.0;
  std::string failure;  ///< without a document: how the job ended and the first line that it complained with
};

/// Instructions that a command of a program executed, or why they were not counted.
struct CountedInstructions {
  std::optional<double> count;
  bool uncountable = false;  ///< there is no valgrind, or it does not know this build's instructions
  std::string failure;
};

/// Runs commands of programs as processes of their own, with their files in a folder that is gone afterwards.
class JobRunner {
 public:
  explicit JobRunner(double seconds_allowed) : seconds_allowed_(seconds_allowed) {}

  JobResult run(const std::filesystem::path& program, const JobWords& words);
  /// Under callgrind, which executes some fifty times slower. `within`: Budget::within.
  CountedInstructions count_instructions(const std::filesystem::path& program, const JobWords& words,
                                         const std::string& within);
  /// The program that is running.
  static std::filesystem::path this_program();

 private:
  struct Files {
    std::filesystem::path folder, out, err;
  };
  Files files_for_next();
  std::vector<std::string> command_line(const std::filesystem::path& program, const JobWords& words,
                                        const Files& files) const;

  TemporaryFolder temporary_;
  double seconds_allowed_;
  int jobs_ = 0;
};

}  // namespace finegauge
