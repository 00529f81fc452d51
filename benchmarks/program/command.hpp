#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "benchmarks/program/progress.hpp"
#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// What the program's exit codes mean. An interrupted run ends with 128 + the signal's number instead.
enum ExitCode : int { exit_ok = 0, exit_check_failed = 1, exit_bad_input = 2 };

/// Bad usage that the option parser cannot see: ends the program with exit_bad_input and this one message.
class UsageError : public std::runtime_error {
 public:
  explicit UsageError(const std::string& message) : std::runtime_error(message) {}
};

/// Options that all commands that compute have in common.
struct CommonOptions {
  std::string out;               ///< directory; empty: results/NAME (result_directory)
  std::vector<std::string> set;  ///< "key=value"
  int threads = 1;
  bool full = false, quick = false, json = false, quiet = false;
  int vtu_every = 0;

  std::filesystem::path directory(const std::string& name) const {
    return out.empty() ? std::filesystem::path("results") / name : std::filesystem::path(out);
  }
};
/// `set_help` tells which keys --set of this command takes, with an example that works.
void add_common_options(CLI::App& command, CommonOptions& options, const std::string& set_help);

/// The --set options; the last one wins for a key given twice. Throws UsageError on one without "=" or without a key.
std::map<std::string, std::string> parse_overrides(const std::vector<std::string>& set);

/// Throws UsageError when no files can be written into a directory, existing or yet to be created: to be asked before
/// anything is computed. Leaves nothing behind.
void require_writable(const std::filesystem::path& directory);

/// Where a command writes: --out, or else results/NAME; where that has NAME.json of another command (scenes and studies
/// may have one name), results/NAME_KIND, so that neither result overwrites the other.
std::filesystem::path result_directory(const CommonOptions& options, const std::string& name, const std::string& kind);

/// So many for the loops of the core. BLAS, and what else uses OpenMP, get one, where the program is linked to such
/// versions of them: their sums depend on how many threads share them, and results shall not.
void use_threads(int count);

/// Writes the result's files, the document to standard output if --json asks for it, and tells on `progress` where
/// the files are. Returns the exit code: 128 + signal when interrupted, 1 when a check failed, else 0.
int finish(ResultDocument& document, const CommonOptions& options, const std::filesystem::path& directory,
           const Progress& progress);

}  // namespace finegauge
