#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_forest.hpp"

namespace finegauge {

/// T: every node from the nodes that do not hang, the same weights for each displacement component.
///
/// Rows sum to one, reproduce linear fields and name masters that do not hang; the row of a node that does not hang is
/// the node itself. Masters are given by reduced number, the position among the nodes that do not hang.
///
/// How it is found. A leaf that contains a node without having it as a corner demands that the node's value is the
/// leaf's interpolation there: one equation. All these equations together are equivalent to a conforming field. They
/// are eliminated one by one, base edges before faces before cells and larger leaves first, each for its own node where
/// that is still free and else for another node in it. Chains over levels, faces split in 2 and in 3, and halves
/// against thirds across one another are then one case: what the equations leave free does not hang.
///
/// The row of a node on the boundary names nodes of its own base face (or edge) only, so that a support of the face
/// holds all of it. Where the equations alone would couple two faces of the body (halves first along one axis here and
/// along the other there can leave one bend that both faces share), that bend is given up. The same goes for a node
/// whose base entity has all its corners in one of BaseMesh::regions: what holds the region holds the node.
struct HangingNodes {
  std::vector<int> row_start;  ///< n_nodes + 1
  std::vector<int> master;     ///< reduced numbers, ascending in a row
  std::vector<double> weight;
  std::vector<int> reduced_of;  ///< per node; -1 for a node that hangs
  std::vector<int> node_of;     ///< per reduced number
  int longest_chain = 0;        ///< most levels of masters that hang themselves, before they were resolved

  int node_count() const { return static_cast<int>(reduced_of.size()); }
  int reduced_count() const { return static_cast<int>(node_of.size()); }
  int hanging_count() const { return node_count() - reduced_count(); }
  bool hangs(int node) const { return reduced_of[node] < 0; }
};

/// `mesh` is a `forest.leaf_mesh(height)` of the forest as it is now, of any height.
HangingNodes find_hanging_nodes(const RefinementForest& forest, const Mesh& mesh);

}  // namespace finegauge
