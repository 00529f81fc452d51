#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/base_mesh.hpp"

namespace finegauge {

/// Edges and faces of a base mesh, numbered, each with a canonical frame that all cells around it agree on.
///
/// Canonical frames: an edge runs from its smaller to its larger node number; a quadrilateral starts at its smallest
/// node and its first axis runs to the smaller of the two neighbours; a triangle lists its nodes ascending.
struct BaseTopology {
  /// How a cell's local face maps onto the canonical face: for a quadrilateral canonical (s, t) = local (a, b) with
  /// `swap` exchanging them and then `flip` reversing each.
  struct FaceView {
    int face;
    bool swap;
    std::array<bool, 2> flip;
  };
  std::vector<std::array<int, 2>> edges;  ///< node numbers, ascending
  std::vector<std::array<int, 4>>
      faces;  ///< quadrilateral: nodes at canonical (0,0) (1,0) (0,1) (1,1); triangle: ascending, -1
  std::vector<std::array<int, 12>> cell_edges;      ///< per cell, by local edge
  std::vector<std::array<FaceView, 6>> cell_faces;  ///< per cell, by local face
  std::vector<std::array<BaseFace, 2>> face_cells;  ///< the one or two cells of a face; cell -1 where there is none
  std::vector<int> edge_cell_start, edge_cells;     ///< cells around an edge
  std::vector<int> node_cell_start, node_cells;     ///< cells around a node
  std::vector<std::uint8_t> node_on_boundary, edge_on_boundary;  ///< 1 on a face that has one cell only
};
BaseTopology base_topology(const BaseMesh& mesh);

}  // namespace finegauge
