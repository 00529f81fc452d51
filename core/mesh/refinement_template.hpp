#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace finegauge {

/// How a cell is subdivided: a hexahedron into n × m × k children along its own axes, 1 to 4 each and not all 1; a
/// tetrahedron always into eight (Bey 1995, red refinement), written {2, 2, 2}.
/// Natural coordinates of the template's nodes are the fractions i / n; its topology is the lattice of the children.
struct RefinementTemplate {
  std::array<std::uint8_t, 3> divisions = {2, 2, 2};
  auto operator<=>(const RefinementTemplate&) const = default;

  int child_count() const { return divisions[0] * divisions[1] * divisions[2]; }
};

inline constexpr int max_divisions = 4;

/// "2x3x3"; and back, throwing std::invalid_argument on anything else.
std::string to_string(const RefinementTemplate& refinement);
RefinementTemplate parse_refinement_template(const std::string& text);

}  // namespace finegauge
