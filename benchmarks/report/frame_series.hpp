#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// What a needle did in a frame.
struct FrameEvent {
  std::string kind;
  double time, tip, force, depth;  ///< NaN where it is not told
};

/// A run's frames, a column each; all of one length, NaN where a frame has no number.
struct FrameSeries {
  std::map<std::string, std::vector<double>> columns;
  std::vector<FrameEvent> events;

  /// Empty where there is no such column, or no number in it.
  const std::vector<double>& column(const std::string& name) const;
  std::size_t frames() const;
};

/// The columns that the report shows, of a document's rows or of the CSV file of a study's case.
FrameSeries frame_series(const Json& rows);
/// Nothing where the file cannot be read or has no header of that sort.
std::optional<FrameSeries> read_frame_series(const std::filesystem::path& csv);

/// Fields of one record of comma-separated values (RFC 4180), `at` behind its line end afterwards.
std::vector<std::string> csv_record(const std::string& text, std::size_t& at);

}  // namespace finegauge
