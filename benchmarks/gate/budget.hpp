#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace finegauge {

/// What a budget is about, and with it how it is judged.
enum class BudgetKind {
  accuracy,      ///< a number of a result, between two bounds
  counter,       ///< a whole number of a result: dofs, iterations, nonzeros, allocations
  instructions,  ///< counted by callgrind, over those of the base build or of another command
  time           ///< of frames, over the base build's or over a calibration kernel; never milliseconds
};
const char* to_string(BudgetKind kind);

/// A command line of this program without its name, as words: {"reproduce", "lshape", "--quick"}.
using JobWords = std::vector<std::string>;
std::string to_string(const JobWords& words);

/// One [[budget]] of a budgets file.
struct Budget {
  std::string name;
  BudgetKind kind = BudgetKind::accuracy;
  JobWords run;
  std::string value;  ///< where in the result the number stands (result_path.hpp); accuracy and counter
  double low = 0.0;   ///< inclusive; of instructions and time: of the ratio
  double high = 0.0;
  JobWords over;  ///< of instructions: the command to compare with; empty: the base build
  /// Of instructions: only those of this function and of what it calls, by its name as callgrind writes it, with the
  /// types of its arguments. Empty: those of the whole process, of which pictures and texts may be nine tenths.
  std::string within;
  /// Of time: the column of the result's rows that holds a frame's milliseconds. processor_ms where none is given: what
  /// a frame's own work takes. frame_ms is the wall clock's, with what others do on the machine.
  std::string frames;
  int percentile = 99;            ///< of time
  bool against_base = false;      ///< of time: interleaved with the base build, else with the calibration kernel
  double slower = 0.10;           ///< of time against the base: the effect that is allowed, a fraction
  std::string reason;             ///< of the bounds
  bool without_base = false;      ///< optional = "base": skipped, and said so, where no base build is given
  bool without_valgrind = false;  ///< optional = "valgrind": likewise where callgrind cannot run the program
  bool slow = false;              ///< left out by --quick

  bool needs_base() const {
    return (kind == BudgetKind::time && against_base) || (kind == BudgetKind::instructions && over.empty());
  }
};

/// Reads and checks a budgets file. Throws SceneError "FILE:LINE: budget[2].low: found ..., allowed ..." on unknown
/// keys, keys of another kind of budget, missing ones, values out of range, names given twice, and on any bound on a
/// stored time.
std::vector<Budget> read_budgets(const std::filesystem::path& file);

}  // namespace finegauge
