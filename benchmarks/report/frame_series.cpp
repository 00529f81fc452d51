#include "benchmarks/report/frame_series.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <utility>

#include "benchmarks/report/report_input.hpp"

namespace finegauge {
namespace {

constexpr std::array shown_columns = {
    "time", "tip_displacement", "force",      "tip_force", "shaft_force",     "dofs",     "cells",
    "eta",  "error_low",        "error_high", "step",      "tolerance_ratio", "frame_ms", "effectivity"};
constexpr double none = std::numeric_limits<double>::quiet_NaN();

void add_events(const Json& events, double time, double tip, std::vector<FrameEvent>& out) {
  if (!events.is_array()) return;
  for (const Json& event : events)
    out.push_back({text_at(event, "kind"), time, tip, number_at(event, "force"), number_at(event, "depth")});
}

/// A column in which no frame has a number is none.
void drop_empty(FrameSeries& series) {
  std::erase_if(series.columns, [](const auto& column) {
    return std::ranges::none_of(column.second, [](double value) { return std::isfinite(value); });
  });
}

double number_of(const std::string& text) {
  double value = none;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : none;
}

}  // namespace

const std::vector<double>& FrameSeries::column(const std::string& name) const {
  static const std::vector<double> empty;
  const auto found = columns.find(name);
  return found == columns.end() ? empty : found->second;
}

std::size_t FrameSeries::frames() const { return columns.empty() ? 0 : columns.begin()->second.size(); }

FrameSeries frame_series(const Json& rows) {
  FrameSeries series;
  for (const char* name : shown_columns) {
    std::vector<double>& column = series.columns[name];
    column.reserve(rows.size());
    for (const Json& row : rows) column.push_back(number_at(row, name));
  }
  for (const Json& row : rows)
    if (const Json* events = find_value(row, "events"))
      add_events(*events, number_at(row, "time"), number_at(row, "tip_displacement"), series.events);
  drop_empty(series);
  return series;
}

std::vector<std::string> csv_record(const std::string& text, std::size_t& at) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quoted) {
      if (c != '"')
        fields.back() += c;
      else if (at + 1 < text.size() && text[at + 1] == '"')
        fields.back() += text[++at];
      else
        quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      fields.emplace_back();
    } else if (c == '\n') {
      ++at;
      break;
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

std::optional<FrameSeries> read_frame_series(const std::filesystem::path& csv) {
  std::ifstream in(csv, std::ios::binary);
  if (!in) return std::nullopt;
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  std::size_t at = 0;
  const std::vector<std::string> header = csv_record(text, at);
  const auto index_of = [&](const std::string& name) { return std::ranges::find(header, name) - header.begin(); };
  const auto known = static_cast<std::ptrdiff_t>(header.size());
  if (index_of("time") == known && index_of("step") == known) return std::nullopt;
  FrameSeries series;
  std::vector<std::pair<std::size_t, std::vector<double>*>> wanted;
  for (const char* name : shown_columns)
    if (const auto index = index_of(name); index < known)
      wanted.emplace_back(static_cast<std::size_t>(index), &series.columns[name]);
  const auto events = static_cast<std::size_t>(index_of("events"));
  const auto last_of = [&](const char* name) {
    const auto found = series.columns.find(name);
    return found == series.columns.end() || found->second.empty() ? none : found->second.back();
  };
  while (at < text.size()) {
    const std::vector<std::string> record = csv_record(text, at);
    for (const auto& [index, column] : wanted)
      column->push_back(index < record.size() ? number_of(record[index]) : none);
    if (events < record.size() && record[events].size() > 2)
      add_events(Json::parse(record[events], nullptr, false), last_of("time"), last_of("tip_displacement"),
                 series.events);
  }
  drop_empty(series);
  return series;
}

}  // namespace finegauge
