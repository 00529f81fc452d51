#include "benchmarks/program/shard.hpp"

#include <charconv>

#include "benchmarks/program/command.hpp"

namespace finegauge {

Shard parse_shard(const std::string& text) {
  if (text.empty()) return {};
  Shard shard;
  const char *first = text.data(), *last = text.data() + text.size();
  const auto number = std::from_chars(first, last, shard.number);
  const bool slash = number.ec == std::errc() && number.ptr != last && *number.ptr == '/';
  const auto of = slash ? std::from_chars(number.ptr + 1, last, shard.of) : number;
  if (!slash || of.ec != std::errc() || of.ptr != last || !(shard.number >= 1 && shard.number <= shard.of))
    throw UsageError("--shard " + text + ": expected I/N, whole numbers with 1 <= I <= N");
  return shard;
}

}  // namespace finegauge
