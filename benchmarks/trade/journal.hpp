#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// All whole lines of a journal, the header first. Throws UsageError for a file that is none.
std::vector<Json> journal_lines(const std::filesystem::path& file);

/// A file of JSON lines in which a sweep writes down each finished job at once: what a kill leaves behind. The first
/// line, the header, says what the sweep is; a last line that the kill cut off counts as never written.
class Journal {
 public:
  /// Reads what is there, and writes nothing. Throws UsageError when there is a journal and `resume` is not asked for,
  /// when it is of another header or of a sweep that runs at this moment, and when a line is not one of ours.
  Journal(std::filesystem::path file, const Json& header, bool resume);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  const std::vector<Json>& lines() const { return lines_; }  ///< without the header, in the order written
  /// Written, after the header where it is the first, and handed to the disk before this returns. Throws
  /// std::runtime_error when it cannot be.
  void append(const Json& line);

 private:
  std::size_t read(const std::string& content, bool resume);
  void begin();
  void write(const std::string& text);
  [[noreturn]] void fail() const;

  std::filesystem::path file_;
  Json header_;
  std::vector<Json> lines_;
  int open_ = -1;          ///< locked while this lives
  std::size_t whole_ = 0;  ///< bytes of whole lines
  bool begun_ = false;     ///< what follows them is cut off
};

}  // namespace finegauge
