#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"
#include "benchmarks/program/shard.hpp"

namespace finegauge {

/// The document of a part of a sweep (--shard), as its run left it.
struct MergePart {
  std::filesystem::path directory;
  Json document;
  Shard shard;
};

/// A kind of document whose parts can be joined. It has one row for each job, in the order of the jobs, and its summary
/// tells `jobs`, how many there are in all parts, and `shard`, "I/N".
struct MergeableKind {
  const char* kind;
  std::string (*row_name)(const Json& row);  ///< what tells a row from all others, for messages
  /// Summary, checks and pictures of the whole from its rows. Throws UsageError, before anything is written, where the
  /// rows are not those of one sweep. `print`: also the lines that the command itself prints.
  void (*conclude)(std::span<const MergePart> parts, ResultDocument& whole, const std::filesystem::path& out,
                   bool print);
};
std::span<const MergeableKind> mergeable_kinds();
/// Of finegauge atlas.
MergeableKind mergeable_atlas();
/// Of finegauge trade.
MergeableKind mergeable_trade();

/// The one document in a directory that is a part. Throws UsageError.
MergePart read_part(const std::filesystem::path& directory);

/// The whole but for what `conclude` adds: kind, name, inputs, rows in the order of an undivided run, and as
/// environment what the parts have in common, the first start and the sum of the times; summary.parts tells each part's
/// own. Parts in any order; one that is there twice with the same rows counts once. Throws UsageError where parts are
/// missing, unfinished or do not fit together.
ResultDocument join_parts(std::span<const MergePart> parts, const MergeableKind& kind);

}  // namespace finegauge
