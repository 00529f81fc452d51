#pragma once

#include <cstddef>
#include <cstdint>

namespace finegauge {

// What a surface from outside may take; beyond any organ, within any machine.
constexpr std::uintmax_t surface_size_limit = std::uintmax_t{1} << 28;  ///< of a file [bytes]
constexpr std::size_t most_surface_triangles = 10'000'000;

}  // namespace finegauge
