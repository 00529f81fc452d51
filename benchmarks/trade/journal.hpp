#pragma once

#include <filesystem>
#include <vector>

#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// A file of JSON lines in which a sweep writes down each finished job at once: what a kill leaves behind. The first
/// line, the header, says what the sweep is; a line that the kill cut off counts as never written.
class Journal {
 public:
  /// Starts the file with the header or, to resume, reads what is there; throws UsageError, without writing anything,
  /// when there is a journal and `resume` is not asked for, and when the one that is there has another header.
  Journal(std::filesystem::path file, const Json& header, bool resume);

  const std::vector<Json>& lines() const { return lines_; }  ///< without the header, in the order written
  /// Written and handed to the disk before this returns. Throws std::runtime_error when it cannot be.
  void append(const Json& line);

 private:
  void write(const Json& line);

  std::filesystem::path file_;
  std::vector<Json> lines_;
};

}  // namespace finegauge
