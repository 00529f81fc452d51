#pragma once

#include <array>

namespace finegauge {

/// Red refinement of a tetrahedron (Bey 1995, section 3): each child's corners as midpoints of the parent's corners
/// {a, b}, a corner itself where a = b. Bey's order keeps the shapes of all descendants in at most three classes, at
/// the price of some children having negative orientation. The inner octahedron is cut along the diagonal 02-13.
inline constexpr std::array<std::array<std::array<int, 2>, 4>, 8> tetrahedron_children = {{
    {{{0, 0}, {0, 1}, {0, 2}, {0, 3}}},
    {{{0, 1}, {1, 1}, {1, 2}, {1, 3}}},
    {{{0, 2}, {1, 2}, {2, 2}, {2, 3}}},
    {{{0, 3}, {1, 3}, {2, 3}, {3, 3}}},
    {{{0, 1}, {0, 2}, {0, 3}, {1, 3}}},
    {{{0, 1}, {0, 2}, {1, 2}, {1, 3}}},
    {{{0, 2}, {0, 3}, {1, 3}, {2, 3}}},
    {{{0, 2}, {1, 2}, {1, 3}, {2, 3}}},
}};

/// Twice the matrix that takes barycentric coordinates in the parent to those in the child, with coordinates in
/// absolute lattice units (they sum to the cell's size, the child's to half of the parent's).
std::array<std::array<int, 4>, 4> tetrahedron_child_map(int child);

}  // namespace finegauge
