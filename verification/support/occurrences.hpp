#pragma once

#include <string>
#include <string_view>

namespace finegauge {

/// How often a part is in the text; overlapping ones count.
inline int occurrences(const std::string& text, std::string_view part) {
  int found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

}  // namespace finegauge
