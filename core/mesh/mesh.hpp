#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/cell_shape.hpp"

namespace finegauge {

/// Natural coordinates inside a base cell in whole lattice units (lattice_unit).
using LatticePoint = std::array<std::uint64_t, 3>;

/// Lattice units along a base cell's edge. Hexahedra: 2^30 · 3^21, so that halves can be nested 30 times and thirds 21
/// times before a coordinate stops being a whole number, and the unit still fits 64 bits. Tetrahedra, which are only
/// halved: 2^40, so that sums of barycentric coordinates fit signed integers. Refinement past that is refused
/// (RefinementForest::can_refine).
constexpr std::uint64_t lattice_unit(CellShape shape) {
  return shape == CellShape::hexahedron ? (std::uint64_t{1} << 30) * 10460353203ull : std::uint64_t{1} << 40;
}

/// Where a leaf lies in its base cell, exactly.
struct LeafFrame {
  int base_cell;
  int depth;
  std::array<LatticePoint, 4> corners;  ///< hexahedron: [0] lower corner, [1] edge lengths; tetrahedron: the corners
};

/// A face of a leaf that lies on the boundary of the body.
struct BoundaryFace {
  int cell;       ///< leaf
  int face;       ///< local face of the leaf
  BaseFace base;  ///< the base face that it is part of
};

/// Base entity that a node belongs to and the node's lattice coordinates in that entity's canonical frame.
/// Two nodes are the same exactly if their identities are equal.
struct NodeIdentity {
  std::uint64_t entity;  ///< dimension (0 vertex, 1 edge, 2 face, 3 cell) · 2^32 + index among the base mesh's
  LatticePoint at;       ///< unused coordinates are zero
  bool operator==(const NodeIdentity&) const = default;
};

/// Averages over the material in a hexahedral cell: of its natural coordinates ξ, η, ζ, and of ηζ, ζξ, ξη. With them
/// the average of each shape function's gradient is known, wherever in its cell the material lies.
using MaterialMeans = std::array<double, 6>;
inline constexpr MaterialMeans means_of_full_cell = {0.5, 0.5, 0.5, 0.25, 0.25, 0.25};

/// Leaf cells of the current refinement, at rest, all of one shape. Knows no dofs and no solution.
/// The numbering of cells and nodes follows from the refinement alone, not from the order in which it came about.
struct Mesh {
  CellShape shape = CellShape::hexahedron;
  Eigen::Matrix3Xd nodes;                           ///< rest positions [m], 3 × n_nodes
  std::vector<std::array<int, max_corners>> cells;  ///< corner nodes (cell_shape.hpp); unused entries are -1
  std::vector<LeafFrame> frames;                    ///< per cell
  std::vector<int> forest_cell;                     ///< per cell, its handle in the forest that made the mesh
  std::vector<NodeIdentity> identities;             ///< per node
  std::vector<std::uint8_t> on_boundary;            ///< per node, 1 on the boundary of the body
  std::vector<BoundaryFace> boundary;               ///< ascending by cell and face
  std::vector<double> fraction;                     ///< per cell, share of its volume that is material, 0 to 1; empty:
                                                    ///< all cells are full
  std::vector<MaterialMeans> means;                 ///< per cell; empty: material lies evenly in all cells

  int cell_count() const { return static_cast<int>(cells.size()); }
  int node_count() const { return static_cast<int>(nodes.cols()); }
};

/// The least share of its full stiffness that a cell keeps, however little material is in it. Mass and the error
/// estimate take the share of material itself.
inline constexpr double least_stiffness_share = 0.01;
inline double material_share(const Mesh& mesh, int cell) { return mesh.fraction.empty() ? 1.0 : mesh.fraction[cell]; }

/// Cells around each node: cells[start[i]] .. cells[start[i + 1] - 1] have node i as a corner, ascending.
struct NodeCells {
  std::vector<int> start;
  std::vector<int> cells;
};
NodeCells cells_around_nodes(const Mesh& mesh);

}  // namespace finegauge
