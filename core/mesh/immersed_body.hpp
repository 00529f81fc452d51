#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/triangle_surface.hpp"

namespace finegauge {

/// A body at rest inside a lattice of equal axis-aligned base cells (hexahedra whose local axes are x, y, z), of which
/// only those that it reaches exist.
///
/// Integrals and inside tests work in lattice coordinates: cells from the lattice's lower corner. There cells are unit
/// cubes between whole numbers, neighbours cut the surface at the same plane bit by bit, and a scene scaled by a power
/// of two has the same shares. The fields after `share` follow from those before (index_surface).
struct ImmersedBody {
  TriangleSurface surface;                              ///< rest positions [m]
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();     ///< lower corner of the lattice [m]
  Eigen::Vector3d cell_size = Eigen::Vector3d::Ones();  ///< [m]
  std::array<int, 3> lattice_cells = {1, 1, 1};
  std::vector<std::array<int, 3>> place;  ///< per base cell, its place in the lattice
  std::vector<double> share;              ///< per base cell, the share of its volume that is material

  Eigen::Matrix3Xd lattice_vertices;        ///< the surface's vertices in lattice coordinates
  std::vector<BoundingBox> triangle_boxes;  ///< per triangle, in lattice coordinates
  /// Triangles whose boxes meet the column of lattice cells at x + lattice_cells[0] y:
  /// column_triangles[column_start[c]] .. column_triangles[column_start[c + 1] - 1], ascending.
  std::vector<int> column_start, column_triangles;
  /// Triangles that come within surface_slack of base cell c, by their boxes and planes, ascending:
  /// cell_triangles[cell_start[c]] .. cell_triangles[cell_start[c + 1] - 1] (index_cells).
  std::vector<int> cell_start, cell_triangles;
};

/// How far past a cell the surface still counts as in it, in natural coordinates of a base cell or leaf. A cell without
/// material is left out of the mesh (least_base_share), and a surface in a plane of the lattice but for round-off runs
/// through such cells: above the thickness of that layer.
inline constexpr double surface_slack = 1e-8;

/// Lattice cells with no more material than this share do not become base cells. A face of the surface in a lattice
/// plane misses it by the round-off of its coordinates, 1e-15 of a body of a hundred cells and a hundred times that
/// for one that lies far from the origin; it must not add a layer of empty cells. What is left out weighs nothing.
inline constexpr double least_base_share = 1e-9;

/// More lattice cells than this are taken for a mistake in the unit of length.
inline constexpr int most_lattice_cells = 4'000'000;

struct ImmersedMeshOptions {
  Eigen::Vector3d cell_size = Eigen::Vector3d::Zero();  ///< edge lengths of a base cell [m]; must be given, > 0
  /// A corner of some lattice cell [m]; the lattice starts whole cells away from it. None: the box around the surface
  /// is centred in the fewest cells that hold it.
  std::optional<Eigen::Vector3d> origin;
};

/// The lattice cells that the body reaches, numbered like their nodes: x fastest, then y, then z. No named surfaces:
/// the lattice's own faces are no place to hold or load a body whose surface lies inside them.
/// The surface must not cut itself: no point may be enclosed twice. Throws std::invalid_argument when it has no
/// triangles, is not closed or is turned inside out, when a cell holds more than itself or less than nothing of
/// it, on options out of range, on more than most_lattice_cells and when no cell holds material.
BaseMesh immersed_mesh(TriangleSurface surface, const ImmersedMeshOptions& options);

/// Fills the fields that follow from the surface and its lattice: lattice_vertices, triangle_boxes, columns. Throws
/// std::invalid_argument when the columns' lists together outgrow int.
void index_surface(ImmersedBody& body);

/// Fills cell_start and cell_triangles from the other fields.
void index_cells(ImmersedBody& body);

/// Whether X [m] lies in the body at rest. A point on the surface may get either answer, and so may one that is off it
/// by the round-off of the coordinates; every other point gets the right one, whatever the ray through it meets.
bool contains(const ImmersedBody& body, const Eigen::Vector3d& X);

/// What does not fit between a base mesh and its body, in words; empty when all does. Base cells must be the lattice
/// cells at their places, corners in order.
std::string validate(const ImmersedBody& body, const BaseMesh& mesh);

/// Rest position of a lattice point [m].
Eigen::Vector3d lattice_position(const ImmersedBody& body, const std::array<int, 3>& at);

}  // namespace finegauge
