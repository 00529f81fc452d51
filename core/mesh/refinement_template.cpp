#include "core/mesh/refinement_template.hpp"

#include <stdexcept>

namespace finegauge {

std::string to_string(const RefinementTemplate& refinement) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0) text += 'x';
    text += static_cast<char>('0' + refinement.divisions[axis]);
  }
  return text;
}

RefinementTemplate parse_refinement_template(const std::string& text) {
  const auto digit = [](char c) { return c >= '1' && c <= '0' + max_divisions; };
  if (text.size() != 5 || text[1] != 'x' || text[3] != 'x' || !digit(text[0]) || !digit(text[2]) || !digit(text[4]) ||
      text == "1x1x1")
    throw std::invalid_argument("template \"" + text + "\": expected n×m×k as in \"2x3x3\", each 1 to 4 and not all 1");
  RefinementTemplate refinement;
  for (int axis = 0; axis < 3; ++axis) refinement.divisions[axis] = static_cast<std::uint8_t>(text[2 * axis] - '0');
  return refinement;
}

}  // namespace finegauge
