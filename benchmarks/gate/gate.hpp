#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "benchmarks/gate/judge.hpp"

namespace finegauge {

struct GateOptions {
  std::optional<std::filesystem::path> base;  ///< the program of the build to compare with
  bool quick = false;                         ///< leaves out slow budgets and instructions
  std::uint32_t seed = 0;                     ///< of the order within blocks
  std::function<void(double fraction, const std::string& doing)> progress = [](double, const std::string&) {};
};

/// A command that was run for its result.
struct GateJob {
  std::string run;
  int exit_code = -1;
  double seconds = 0.0;
};

struct GateResult {
  std::vector<Judgement> judgements;  ///< one per budget, in their order; fewer when interrupted
  std::vector<GateJob> jobs;
};

/// Runs what the budgets name, each command once for all budgets that read its result, and judges them.
GateResult run_gate(std::span<const Budget> budgets, const GateOptions& options);

/// Counters that no scene tells: of the L-shape's matrix, uniform and refined by the paper's loop, the entries of T,
/// the blocks of the reduced matrix, the nonzeros of its factor, and the iterations of the solve. A summary for
/// `finegauge gate --counters`.
Json exact_counters();

}  // namespace finegauge
