#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// A trace in the trace-event format (JSON object form), which chrome://tracing and https://ui.perfetto.dev open:
/// complete events "X" on one track, those within others below them, counters "C", and metadata "M" with the names.
/// Times in nanoseconds of any clock; written in microseconds since the first event, as the format has it.
class TraceEvents {
 public:
  explicit TraceEvents(const std::string& process);
  /// Events that overlap must contain one another.
  void add_span(const std::string& name, std::int64_t begin, std::int64_t end, Json arguments = Json::object());
  /// A curve; one value for each series.
  void add_counter(const std::string& name, std::int64_t at, const std::vector<std::pair<std::string, double>>& values);
  /// The file's content. `notes`: of the trace, by key.
  std::string text(const Json& notes) const;

 private:
  double microseconds(std::int64_t at);
  Json events_ = Json::array();
  bool started_ = false;
  std::int64_t start_ = 0;
};

}  // namespace finegauge
