#pragma once

#include <vector>

#include "core/adapt/marking.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

/// Refines the leaves named by their cell numbers in `mesh`, the forest's current leaf mesh; those that the lattice
/// forbids (RefinementForest::can_refine) are left. Returns how many were refined.
///
/// A division by 4 is made as two halvings, one inside the other: the same leaves, and a mesh in between for the
/// multigrid hierarchy, which saves a quarter of the iterations. It counts as two levels of depth.
int apply_refinements(RefinementForest& forest, const Mesh& mesh, const std::vector<Refinement>& refinements);

/// Refines every leaf.
void refine_uniformly(RefinementForest& forest, RefinementTemplate refinement = {});

}  // namespace finegauge
