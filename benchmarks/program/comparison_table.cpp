#include <algorithm>
#include <array>
#include <sstream>
#include <utility>

#include "benchmarks/program/study.hpp"

namespace finegauge {
namespace {

/// Columns that a text takes on the terminal: UTF-8 characters, not bytes.
int shown_width(const std::string& text) {
  return static_cast<int>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, int width) {
  return text + std::string(static_cast<std::size_t>(std::max(0, width - shown_width(text))), ' ');
}

std::vector<std::string> wrapped(const std::string& text, int width) {
  std::vector<std::string> lines(1);
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && shown_width(lines.back()) + 1 + shown_width(word) > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

std::vector<std::string> comparison_table(const std::vector<ComparisonRow>& rows) {
  constexpr int width = 118;
  const ComparisonRow header{"", "paper", "here", "why they differ"};
  std::array<int, 3> widths = {0, shown_width(header.paper), shown_width(header.here)};
  for (const ComparisonRow& row : rows) {
    widths[0] = std::max(widths[0], shown_width(row.quantity));
    widths[1] = std::max(widths[1], shown_width(row.paper));
    widths[2] = std::max(widths[2], shown_width(row.here));
  }
  const int left = widths[0] + widths[1] + widths[2] + 9;
  std::vector<std::string> lines;
  const auto add = [&](const ComparisonRow& row) {
    const std::vector<std::string> why = wrapped(row.why, std::max(24, width - left));
    for (std::size_t i = 0; i < why.size(); ++i) {
      std::string line = padded(i ? "" : row.quantity, widths[0]) + " | " + padded(i ? "" : row.paper, widths[1]) +
                         " | " + padded(i ? "" : row.here, widths[2]) + " | " + why[i];
      line.erase(line.find_last_not_of(' ') + 1);
      lines.push_back(line);
    }
  };
  add(header);
  std::string rule;
  for (const int w : widths) rule += std::string(static_cast<std::size_t>(w) + 1, '-') + "+-";
  lines.push_back(rule + std::string(static_cast<std::size_t>(shown_width(header.why)), '-'));
  for (const ComparisonRow& row : rows) add(row);

  std::vector<std::pair<std::string, std::string>> told;
  int longest = 0;
  for (const ComparisonRow& row : rows) {
    if (row.place.empty() || std::ranges::find(told, std::pair(row.paper, row.place)) != told.end()) continue;
    told.emplace_back(row.paper, row.place);
    longest = std::max(longest, shown_width(row.paper));
  }
  if (!told.empty()) lines.insert(lines.end(), {"", "where the paper has it:"});
  for (const auto& [entry, place] : told) {
    const std::vector<std::string> wrapped_place = wrapped(place, std::max(24, width - longest - 4));
    for (std::size_t i = 0; i < wrapped_place.size(); ++i)
      lines.push_back("  " + padded(i ? "" : entry, longest) + "  " + wrapped_place[i]);
  }
  return lines;
}

}  // namespace

void add_comparison(const std::vector<ComparisonRow>& rows, StudyResult& result) {
  std::string note;
  for (const std::string& line : result.table) note += (note.empty() || line.empty() ? "" : " ") + line;
  if (!note.empty()) result.summary["comparison_note"] = note;
  for (const std::string& line : comparison_table(rows)) result.table.push_back(line);
  Json& comparison = result.summary["comparison"] = Json::array();
  for (const ComparisonRow& row : rows) {
    Json entry = {{"quantity", row.quantity}, {"paper", row.paper}, {"here", row.here}, {"why", row.why}};
    if (!row.place.empty()) entry["place"] = row.place;
    comparison.push_back(std::move(entry));
  }
}

}  // namespace finegauge
