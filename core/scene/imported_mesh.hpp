#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>

#include "core/mesh/base_mesh.hpp"

namespace finegauge {

/// Corners as files list them (VTK, gmsh) in the order of cell_shape.hpp; unused entries are -1.
std::array<int, max_corners> corners_from_file_order(CellShape shape, std::span<const int> listed);

/// What is wrong with a cell's rest shape, in words that complete "found ..., allowed ..."; empty when it is sound.
/// A sound cell has distinct corners and a positive Jacobian determinant at its centre and its 2×2×2 Gauss points,
/// where the mechanics looks at it. Not at its corners: in the patch test of MacNeal & Harder (1985), which every code
/// has to pass, one corner of one cell has a slightly negative one.
std::string cell_defect(CellShape shape, const Eigen::Matrix3Xd& nodes, const std::array<int, max_corners>& cell);

/// A defect of how cells fit together, and the cell that shows it.
struct ConnectionDefect {
  int cell = -1;  ///< -1 when there is no defect
  std::string words;
};
/// Three cells on a face, or two on the same side of it (which a cell listed twice is, too).
ConnectionDefect connection_defect(const BaseMesh& mesh);

/// A node without a cell, or -1.
int unused_node(const BaseMesh& mesh);

}  // namespace finegauge
