#pragma once

#include <vector>

#include "core/mesh/hanging_nodes.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

/// Per node the levels of masters that its value goes through before only nodes are left that do not hang: 0 for those,
/// 1 where no master hangs, one more than the largest among its masters else. T itself has the chains resolved.
///
/// Found from the leaves, not from T: a node's masters are the corners of the largest leaf that has it inside a face or
/// an edge. That is one way to T where all leaves are refined by one template; where faces split in halves and in
/// thirds meet, masters are a choice, and the core's may differ. Hexahedra only.
std::vector<int> chain_lengths(const RefinementForest& forest, const Mesh& mesh, const HangingNodes& hanging);

/// How many nodes have each length; entry 0 counts those that do not hang.
std::vector<int> chain_histogram(const std::vector<int>& lengths);

}  // namespace finegauge
