#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/program/study.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// What one insertion into an organ, the withdrawal and the rest after it took, and what they left behind.
struct OrganCycle {
  double frame_ms = 0.0;  ///< median over its frames [ms]
  double new_ms = 0.0;    ///< the same of a body that is new in every cycle, a frame of each in turn
  double ratio = 0.0;     ///< median over the frames of their time over that of the new body's frame beside it: what
                          ///< else the machine does is in both
  std::optional<double> allocations;  ///< heap blocks asked for in a frame without change of mesh or contact, median
  double resident_mb = 0.0;           ///< of the process, at the end, free blocks given back first
  std::optional<std::int64_t> heap_bytes;  ///< in use at the end
  std::int64_t storage_bytes = 0;  ///< of the forest and the history of adaptation at the end, capacities included
  int most_dofs = 0, dofs_at_rest = 0;
  double left_u = 0.0, left_v = 0.0;  ///< largest displacement and velocity at the end over the cycle's largest
  int punctures = 0, exits = 0, unconverged = 0;
  std::string changed;  ///< the first of what is not bit for bit as at the start, in words; empty: all is
};

struct OrganRun {
  int dofs_start = 0;  ///< before the first cycle
  std::vector<OrganCycle> cycles;
};
/// `count` cycles of the scene's first stroke, its way back, and half a second of rest. Stops early when interrupted.
/// The scene has a needle, a stroke and nothing that moves without the needle.
OrganRun run_organ_cycles(const Scene& scene, int count, const std::function<void(double)>& progress,
                          const std::function<bool()>& interrupted);

/// A line through values of cycles 0, 1, 2, ... by least squares.
struct Trend {
  double growth = 0.0;       ///< of the line from the first value to the last
  double uncertainty = 0.0;  ///< standard error of it, from the scatter about the line
};
/// Of three values or more; throws std::invalid_argument otherwise.
Trend trend(std::span<const double> values);

/// What holds whatever the machine does: all came back in every cycle, and nothing piled up. Of two cycles or more.
Json checks_of_return(const std::string& name, const OrganRun& run);
/// Frame times and resident memory do not grow, within what they scatter. Of twenty cycles or more.
Json checks_of_growth(const std::string& name, const std::vector<OrganCycle>& cycles);

/// The part of `reproduce liver-phantom --full`: a hundred cycles of that scene, refined by the paper's rule and within
/// tolerances; adds rows (summary.cycles), checks, plots and a table to the result. before: share of the study's time
/// that has passed.
void add_organ_cycles(const StudyContext& context, double before, StudyResult& result);

}  // namespace finegauge
