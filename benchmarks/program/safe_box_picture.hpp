#pragma once

#include <optional>
#include <string>
#include <vector>

#include "verification/support/atlas.hpp"

namespace finegauge {

/// An axis of the atlas and what was found on it.
struct SafeBoxRow {
  const AtlasAxis* axis;
  AtlasSweep found;
};

/// The box in which the simulation is sound, an axis a row: a bar over the values tried, logarithmic, zero at its left
/// end. Filled where there are answers, hatched where values are refused in words, red crosses where it fails.
std::string safe_box_svg(const std::vector<SafeBoxRow>& rows, const std::string& note);

/// "1e-9", "0.05", "30".
std::string brief_number(double value);
/// "1e-9 to 30", or "none".
std::string range_text(const std::optional<AtlasRange>& range);

}  // namespace finegauge
