#pragma once

#include <algorithm>
#include <cassert>

#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

/// Two numbers closer than this share of themselves are a tie: far above what the root in η and its square lose, far
/// below any error that means something.
inline constexpr double marking_tie = 0x1p-40;

/// Whether a >= b for squares, and whether a <= b, ties included.
inline bool at_least(double a, double b) { return a >= b * (1.0 - marking_tie); }
inline bool at_most(double a, double b) { return a <= b * (1.0 + marking_tie); }

inline double square(double x) { return x * x; }

/// Such a division is two levels (apply_refinements.hpp).
inline bool divides_by_four(RefinementTemplate refinement) {
  return std::count(refinement.divisions.begin(), refinement.divisions.end(), 4) > 0;
}

/// visit(parent, first, count) for each family of leaves: a cell of the forest and the cells first to first + count - 1
/// of the mesh. The children of a cell follow one another in the mesh, as they do in the forest.
template <class Visit>
void visit_families(const RefinementForest& forest, const Mesh& mesh, const Visit& visit) {
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const int handle = mesh.forest_cell[cell], parent = forest.cell(handle).parent;
    if (parent < 0 || handle != forest.cell(parent).first_child || !forest.can_coarsen(parent)) continue;
    const int count = forest.cell(parent).refinement.child_count();
    assert(mesh.forest_cell[cell + count - 1] == handle + count - 1);
    visit(parent, cell, count);
  }
}

}  // namespace finegauge
