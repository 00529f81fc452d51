#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/base_topology.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_template.hpp"

namespace finegauge {

/// One tree of refinements per base cell.
///
/// Invariant: `leaf_mesh` (but for the handles in Mesh::forest_cell) is a function of the base mesh and of the set of
/// refined cells with their templates, never of the order in which they were refined or of what was refined and
/// coarsened before. Handles of cells stay valid until the cell is removed by coarsening; the storage of removed
/// families is used again, by families of any size.
class RefinementForest {
 public:
  struct Cell {
    int parent;       ///< -1 for a base cell
    int first_child;  ///< -1 for a leaf; children are consecutive, the first axis runs fastest
    int base;         ///< base cell
    int depth;
    RefinementTemplate refinement;             ///< of a cell that is not a leaf
    std::array<std::uint64_t, 3> per_edge;     ///< cells of this size along each axis of the base cell
    double share = 1.0;                        ///< of the cell's volume that is material; 1 without an immersed body
    MaterialMeans means = means_of_full_cell;  ///< where that material lies
  };

  /// Throws std::invalid_argument when the mesh is not sound or does not fit its immersed body.
  explicit RefinementForest(BaseMesh base);

  const BaseMesh& base() const { return base_; }
  const BaseTopology& topology() const { return topology_; }

  /// Base cells are the first handles, in order.
  const Cell& cell(int handle) const { return cells_[handle]; }
  int handle_count() const { return static_cast<int>(cells_.size()); }  ///< upper bound of handles, free ones included
  bool is_leaf(int handle) const { return cells_[handle].first_child < 0; }
  int leaf_count() const { return leaf_count_; }
  std::size_t storage_bytes() const;

  /// Whether the leaf's children still lie on the lattice (mesh.hpp, lattice_unit). Tetrahedra know 2x2x2 only.
  bool can_refine(int leaf, RefinementTemplate refinement) const;
  /// Replaces a leaf by its children. Precondition: can_refine. With an immersed body where each child's material lies
  /// is integrated here, once; the children of a full or empty cell are full or empty.
  void refine(int leaf, RefinementTemplate refinement);
  /// Whether the cell has children and all of them are leaves.
  bool can_coarsen(int handle) const;
  /// Removes the children. The exact inverse of refine. Precondition: can_coarsen.
  void coarsen(int handle);

  /// Sweeps that each coarsen every family of leaves until only the cell is left, for all cells; zero for a leaf.
  std::vector<int> heights() const;
  /// The leaves as a mesh. With height > 0: the mesh after that many such sweeps, the levels of a multigrid hierarchy.
  Mesh leaf_mesh(int height = 0) const { return leaf_mesh(height, heights()); }
  /// The same for who has the heights() of the forest as it is now at hand.
  Mesh leaf_mesh(int height, const std::vector<int>& heights) const;

 private:
  BaseMesh base_;
  BaseTopology topology_;
  std::vector<Cell> cells_;
  std::map<int, int> free_;  // unused handles: first of a run, its length; no two runs touch, none ends the storage
  int leaf_count_;
};

/// Volume of a cell in its base cell's natural coordinates, as a share of the base cell.
double share_of_base_cell(const RefinementForest::Cell& cell);
/// Frames of the children of a cell, in their order.
void child_frames(CellShape shape, const LeafFrame& frame, RefinementTemplate refinement,
                  std::vector<LeafFrame>& children);
LeafFrame base_frame(CellShape shape, int base_cell);
/// Frame of a cell of a forest of hexahedra, from its ancestors.
LeafFrame hexahedron_frame(const RefinementForest& forest, int handle);

/// Our promises, checked one by one: what is broken, in words; empty when nothing is. For tests and debug builds.
std::string validate(const RefinementForest& forest);

}  // namespace finegauge
