#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "benchmarks/measure/measured_run.hpp"
#include "benchmarks/trade/design_space.hpp"

namespace finegauge {

/// Points of Sobol's sequence (GSL) in the unit cube, shifted modulo one by an amount that a seed decides (Cranley &
/// Patterson 1976): as even as the sequence for every seed.
class QuasiRandom {
 public:
  QuasiRandom(int dimensions, std::uint64_t seed);
  /// Point `index` of the sequence, from 0 on; asked in ascending order.
  std::vector<double> point(int index);

 private:
  std::vector<double> shift_;
  int dimensions_, next_ = 0;
  std::shared_ptr<void> sequence_;
};

/// One setting and what became of it.
struct TradeJob {
  int number = 0;  ///< 0: the scene as it is
  TradeSetting setting;
  bool elsewhere = false;  ///< of another shard, and not tried here
  MeasuredRun run;
  std::vector<std::vector<double>> more_passes;  ///< frame times of the rounds in which the front is timed again [ms]
};

/// Which settings are to be tried next, from those that were. A function of the seed and of what the finished jobs
/// found by exact counts, never of a time, so that a sweep that is resumed goes on as if nothing had happened.
class TradePlan {
 public:
  /// `fill_only`: no rounds around fronts, which take the jobs of all shards together.
  TradePlan(std::vector<TradeAxis> axes, int points, std::uint64_t seed, bool fill_only = false);

  /// Number 0 is the scene's own setting; three fifths of the points fill the space evenly, the rest come in rounds
  /// around the fronts of work and error, one front for each error, of all jobs before the round.
  /// The next round's settings; empty when all points are planned or nothing new is left near the fronts. Jobs by
  /// number, all of the rounds before.
  std::vector<TradeSetting> next_round(const std::vector<TradeJob>& finished);
  const std::vector<TradeAxis>& axes() const { return axes_; }

 private:
  bool take(const TradeSetting& setting, std::vector<TradeSetting>& round);
  void fill(std::vector<TradeSetting>& round);
  void refine(const std::vector<TradeJob>& finished, std::vector<TradeSetting>& round);

  std::vector<TradeAxis> axes_;
  int points_;
  bool fill_only_;
  QuasiRandom random_;
  int index_ = 0;                   ///< of the sequence
  std::set<TradeSetting> planned_;  ///< of all rounds
};

}  // namespace finegauge
