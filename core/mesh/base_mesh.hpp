#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/cell_shape.hpp"

namespace finegauge {

/// A face of a base cell, by cell and local face number (cell_shape.hpp).
struct BaseFace {
  int cell;
  int face;
  auto operator<=>(const BaseFace&) const = default;
};

struct ImmersedBody;

/// The conforming mesh before any refinement: all cells of one shape, distorted or not, with named boundary faces.
struct BaseMesh {
  CellShape shape = CellShape::hexahedron;
  Eigen::Matrix3Xd nodes;                                 ///< rest positions [m], 3 × n_nodes
  std::vector<std::array<int, max_corners>> cells;        ///< corner nodes in our order; unused entries are -1
  std::map<std::string, std::vector<BaseFace>> surfaces;  ///< named sets of boundary faces, each sorted
  std::map<std::string, std::vector<int>> regions;  ///< named sets of nodes, each ascending; names unlike surfaces'
  std::shared_ptr<const ImmersedBody> body;         ///< what fills the cells in part; none: they are full
};

/// A box of lattice cells [first, last) per axis that `box_mesh` leaves out.
struct RemovedBlock {
  std::array<int, 3> first, last;
};

struct BoxMeshOptions {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< lower corner [m]
  Eigen::Vector3d size = Eigen::Vector3d::Ones();    ///< edge lengths [m], > 0
  std::array<int, 3> cells = {1, 1, 1};              ///< lattice cells per axis, >= 1
  CellShape shape = CellShape::hexahedron;           ///< a tetrahedral box splits each lattice cell in six (Kuhn)
  std::optional<RemovedBlock> removed;               ///< inside the lattice and not all of it
};

/// A box, or a box with a removed block. Surfaces: x_min, x_max, y_min, y_max, z_min, z_max on the box's planes, and
/// `notch` on the faces that the removed block lays bare. Throws std::invalid_argument on options out of range.
BaseMesh box_mesh(const BoxMeshOptions& options);

/// A hexahedral mesh on the tensor product of three ascending lists of coordinates, a removed block by lattice cells.
BaseMesh tensor_mesh(const std::array<std::vector<double>, 3>& coordinates, const std::optional<RemovedBlock>& removed);

/// What `validate` found first, in words that name the cell or node; empty when the mesh is sound.
/// Checks: indices in range, no repeated corner, finite coordinates, positive Jacobian at the quadrature
/// points of every cell, at most two cells on a face, no node without a cell, surfaces on the boundary, regions of
/// nodes that exist, under names of their own.
std::string validate(const BaseMesh& mesh);

/// All faces that belong to one cell only, ascending.
std::vector<BaseFace> boundary_faces(const BaseMesh& mesh);

}  // namespace finegauge
