#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/program/shard.hpp"
#include "benchmarks/trade/sweep.hpp"

namespace finegauge {

struct TradeOptions {
  std::filesystem::path scene;
  std::vector<std::string> set;        ///< of the user: the scene that is swept
  std::vector<std::string> reference;  ///< --set arguments on top of trade_reference's, for the coarser one too
  std::vector<std::string> coarser;    ///< and on top of both for the coarser one
  int points = 40;
  std::uint64_t seed = 1;
  double seconds = 600.0;  ///< that one run may take; the reference takes what it takes
  int timing_rounds = 3;   ///< in which the settings of the front are run again, in random order
  int threads = 1;         ///< of runs whose setting chooses none, and of the reference
  Shard shard;             ///< of several, the settings fill the space and none comes nearer to the front
  bool resume = false;
  std::filesystem::path directory;       ///< of journal and reference
  std::filesystem::path reference_from;  ///< another sweep's directory that has the reference; empty: none
  std::function<void(double fraction, const std::string& doing)> progress = [](double, const std::string&) {};
  std::function<bool()> interrupted = [] { return false; };
};

/// All that a sweep found.
struct TradeSweep {
  std::vector<TradeAxis> axes;
  std::vector<TradeJob> jobs;  ///< by number
  std::vector<std::string> reference_overrides;
  std::map<std::string, double> reference_errors;  ///< how far a coarser reference is from it, by quantity
  bool finished = false;                           ///< false when interrupted
};

/// Reference, settings, timing; each job in a process of its own, written to the journal as it ends. Throws SceneError
/// and UsageError before anything is written, std::runtime_error when the reference cannot be computed.
TradeSweep run_trade(const TradeOptions& options);

/// Of a sweep of this scene in this directory.
std::filesystem::path journal_file(const std::filesystem::path& directory, const std::string& scene);

/// Once more, in a process of its own and against the sweep's reference.
MeasuredRun run_again(const TradeOptions& options, const TradeSweep& sweep, const TradeSetting& setting, int passes);

/// The job's frame times of all passes [ms].
std::vector<std::vector<double>> all_passes(const TradeJob& job);

/// Whether the job's frame times may be compared with others': once the front was timed again, only those are that
/// were. A setting that was timed once may owe its place to luck.
bool counts(const std::vector<TradeJob>& jobs, const TradeJob& job);

/// The jobs on the front of p99 and of the error of a quantity, by ascending p99; of those that count.
std::vector<std::size_t> timed_front(const std::vector<TradeJob>& jobs, const std::string& quantity);

}  // namespace finegauge
