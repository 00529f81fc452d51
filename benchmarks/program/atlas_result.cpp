#include "benchmarks/program/atlas_result.hpp"

#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "benchmarks/program/atomic_file.hpp"

namespace finegauge {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

Json to_json(const std::optional<AtlasRange>& range) {
  return {{"low", range ? range->low : none}, {"high", range ? range->high : none}};
}

/// Limits must not shrink.
void add_checks(const AtlasAxis& axis, const std::string& what, const std::optional<AtlasRange>& found,
                const AtlasRange& asked, const std::vector<AtlasPoint>& tried, Json& checks) {
  checks.push_back(check(axis.name + "." + what + ".low", found ? found->low : none, tried.front().value, asked.low));
  checks.push_back(check(axis.name + "." + what + ".high", found ? found->high : none, asked.high, tried.back().value));
}

}  // namespace

Json atlas_row(const AtlasAxis& axis, const AtlasPoint& point) {
  Json row = {{"axis", axis.name}, {"value", point.value}, {"ok", point.ok}, {"refused", point.refused}};
  row["measure"] = point.measure;
  if (!std::isfinite(point.measure)) row["measure_reason"] = point.why;
  row["why"] = point.why;
  return row;
}

AtlasPoint atlas_point(const Json& row) {
  AtlasPoint point;
  point.value = row.at("value").get<double>();
  point.ok = row.at("ok").get<bool>();
  point.refused = row.at("refused").get<bool>();
  point.measure = row.at("measure").is_number() ? row.at("measure").get<double>() : none;
  point.why = row.at("why").get<std::string>();
  return point;
}

std::string atlas_scene_name(const AtlasAxis& axis, const AtlasPoint& point) {
  return axis.name + "_" + brief_number(point.value) + ".toml";
}

void summarize_axes(const std::vector<SafeBoxRow>& rows, bool whole, ResultDocument& document) {
  for (const SafeBoxRow& row : rows) {
    const AtlasAxis& axis = *row.axis;
    document.summary["axes"][axis.name] = {{"unit", axis.unit},     {"about", axis.about},   {"truth", axis.truth},
                                           {"normal", axis.normal}, {"reason", axis.reason}, {"group", axis.group}};
    if (!whole) continue;  // a part of the values says nothing of the limits
    document.summary["safe"][axis.name] = to_json(row.found.safe);
    document.summary["answered"][axis.name] = to_json(row.found.answered);
    add_checks(axis, "safe", row.found.safe, axis.safe, row.found.points, document.checks);
    add_checks(axis, "answered", row.found.answered, axis.answered, row.found.points, document.checks);
  }
}

void print_axis(const SafeBoxRow& row) {
  const AtlasAxis& axis = *row.axis;
  std::printf("%-36s answered %-18s sound %-18s%s\n", axis.name.c_str(), range_text(row.found.answered).c_str(),
              range_text(row.found.safe).c_str(), axis.unit.empty() ? "" : (" [" + axis.unit + "]").c_str());
  std::printf("  %s; against %s\n", axis.about.c_str(), axis.truth.c_str());
  std::printf("  %s\n", axis.reason.c_str());
  for (const AtlasPoint& point : row.found.first_failing)
    std::printf("  FAILS at %s: %s\n", brief_number(point.value).c_str(), point.why.c_str());
}

void write_safe_box(const std::vector<SafeBoxRow>& rows, const ResultDocument& document,
                    const std::filesystem::path& directory) {
  std::string note = std::to_string(document.rows.size()) + " values on " + std::to_string(rows.size()) + " axes";
  note += ", version " + document.environment.version + " (" + document.environment.commit + ")";
  write_file_atomically(directory / "safe_box.svg", safe_box_svg(rows, note));
}

}  // namespace finegauge
