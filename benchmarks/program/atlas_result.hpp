#pragma once

#include <filesystem>
#include <vector>

#include "benchmarks/program/result_document.hpp"
#include "benchmarks/program/safe_box_picture.hpp"

namespace finegauge {

/// A value of an axis as a row of the result, and back. The scene is not in the row.
Json atlas_row(const AtlasAxis& axis, const AtlasPoint& point);
AtlasPoint atlas_point(const Json& row);

/// Name of the file with the scene of a failing point.
std::string atlas_scene_name(const AtlasAxis& axis, const AtlasPoint& point);

/// Summary of the axes: what they are and, where all of their values were tried (`whole`), their limits, with the
/// checks that these have not shrunk.
void summarize_axes(const std::vector<SafeBoxRow>& rows, bool whole, ResultDocument& document);

/// What was found on an axis, on standard output.
void print_axis(const SafeBoxRow& row);

/// DIRECTORY/safe_box.svg of all rows.
void write_safe_box(const std::vector<SafeBoxRow>& rows, const ResultDocument& document,
                    const std::filesystem::path& directory);

}  // namespace finegauge
