#pragma once

#include <string>

namespace finegauge {

/// A part of a sweep: every `of`-th job, from the `number`-th on, 1 <= number <= of. Jobs count in the order in which
/// an undivided run does them.
struct Shard {
  int number = 1, of = 1;

  bool has(std::size_t job) const { return job % static_cast<std::size_t>(of) == static_cast<std::size_t>(number - 1); }
};

/// The value I/N of --shard; empty: all. Throws UsageError.
Shard parse_shard(const std::string& text);

}  // namespace finegauge
