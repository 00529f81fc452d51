#include <algorithm>

#include "benchmarks/commands/merge.hpp"
#include "benchmarks/program/atlas_result.hpp"
#include "benchmarks/program/command.hpp"
#include "verification/studies/atlas.hpp"

namespace finegauge {
namespace {

std::string point_name(const Json& row) {
  return row.at("axis").get<std::string>() + " = " + brief_number(row.at("value").get<double>());
}

/// The rows by axes, in the order of the atlas, values ascending: what every sweep does, so that rows in any other
/// order come from parts of different sweeps.
std::vector<SafeBoxRow> axes_of(const Json& rows) {
  std::vector<SafeBoxRow> axes;
  std::vector<AtlasPoint> points;
  const auto close_axis = [&] {
    if (!axes.empty()) axes.back().found = judge(*axes.back().axis, std::move(points));
    points.clear();
  };
  for (const Json& row : rows) {
    const auto name = row.at("axis").get<std::string>();
    const auto known = std::ranges::find(atlas_axes(), name, &AtlasAxis::name);
    if (known == atlas_axes().end())
      throw UsageError("merge: found a row of the axis " + name + ", which is not known");
    if (axes.empty() || axes.back().axis != &*known) {
      if (!axes.empty() && axes.back().axis > &*known)
        throw UsageError("merge: found parts of different sweeps: " + point_name(row) + " is not in its place");
      close_axis();
      axes.push_back({&*known, {}});
    }
    points.push_back(atlas_point(row));
    if (points.size() > 1 && !(points[points.size() - 2].value < points.back().value))
      throw UsageError("merge: found parts of different sweeps: " + point_name(row) + " is not in its place");
  }
  close_axis();
  return axes;
}

/// What a part told of its first failing points, and their files.
Json copy_failing(std::span<const MergePart> parts, const SafeBoxRow& row, const std::filesystem::path& out) {
  Json failing = Json::array();
  for (const AtlasPoint& point : row.found.first_failing)
    for (const MergePart& part : parts) {
      const Json& told = part.document.at("summary").at("first_failing");
      const auto entry = std::ranges::find_if(
          told, [&](const Json& one) { return one.at("axis") == row.axis->name && one.at("value") == point.value; });
      if (entry == told.end()) continue;
      failing.push_back(*entry);
      std::vector<std::string> files = entry->value("files", std::vector<std::string>());
      if (entry->contains("scene")) files.push_back(entry->at("scene").get<std::string>());
      for (const std::string& file : files) {
        // A name, not a path: nothing is to be written outside of `out`.
        const std::filesystem::path name = std::filesystem::path(file).filename();
        std::error_code gone;  // the entry tells which scene it was all the same
        std::filesystem::copy_file(part.directory / name, out / name, std::filesystem::copy_options::overwrite_existing,
                                   gone);
      }
      break;
    }
  return failing;
}

void conclude_atlas(std::span<const MergePart> parts, ResultDocument& whole, const std::filesystem::path& out,
                    bool print) {
  const std::vector<SafeBoxRow> rows = axes_of(whole.rows);
  const Json told = std::move(whole.summary["parts"]);
  whole.summary.erase("parts");
  summarize_axes(rows, true, whole);
  std::filesystem::create_directories(out);
  Json failing = Json::array();
  double memory = 0.0;
  for (const SafeBoxRow& row : rows) {
    for (const Json& entry : copy_failing(parts, row, out)) failing.push_back(entry);
    if (print) print_axis(row);
  }
  for (const MergePart& part : parts)
    memory = std::max(memory, part.document.at("summary").at("peak_memory_mb").get<double>());
  whole.summary["first_failing"] = failing;
  whole.summary["peak_memory_mb"] = memory;
  whole.summary["parts"] = told;
  write_safe_box(rows, whole, out);
}

}  // namespace

MergeableKind mergeable_atlas() { return {"atlas", point_name, conclude_atlas}; }

}  // namespace finegauge
