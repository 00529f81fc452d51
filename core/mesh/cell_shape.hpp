#pragma once

#include <Eigen/Core>
#include <array>

/// The two cell shapes: corner order, faces, edges and shape functions in natural coordinates.
///
/// Natural coordinates run over [0, 1] (not [-1, 1]) so that template nodes are plain fractions.
///
/// Corner order of the hexahedron, the one place that decides it: corner c lies at natural coordinates
/// (c & 1, (c >> 1) & 1, (c >> 2) & 1). Files use the order of VTK and gmsh (bottom counter-clockwise, then top);
/// `vtk_corner_order` converts.
///
/// The tetrahedron has corners at the origin and at the three unit points: N0 = 1 - x - y - z, N1 = x, N2 = y, N3 = z.
/// Its children may have negative orientation (Bey's refinement, see refinement_template.hpp); volumes use |det|.
namespace finegauge {

enum class CellShape { hexahedron, tetrahedron };

inline constexpr int max_corners = 8;

constexpr int corner_count(CellShape shape) { return shape == CellShape::hexahedron ? 8 : 4; }
constexpr int face_count(CellShape shape) { return shape == CellShape::hexahedron ? 6 : 4; }
constexpr int face_corner_count(CellShape shape) { return shape == CellShape::hexahedron ? 4 : 3; }
constexpr int edge_count(CellShape shape) { return shape == CellShape::hexahedron ? 12 : 6; }

/// Corners of a hexahedron's face f = 2 axis + side, in the order (0,0), (1,0), (0,1), (1,1) of the two other axes
/// taken cyclically (axis + 1, axis + 2).
inline constexpr std::array<std::array<int, 4>, 6> hexahedron_faces = {
    {{0, 2, 4, 6}, {1, 3, 5, 7}, {0, 4, 1, 5}, {2, 6, 3, 7}, {0, 1, 2, 3}, {4, 5, 6, 7}}};
/// Corners of a tetrahedron's face f, the one opposite to corner f.
inline constexpr std::array<std::array<int, 4>, 4> tetrahedron_faces = {
    {{1, 2, 3, -1}, {0, 2, 3, -1}, {0, 1, 3, -1}, {0, 1, 2, -1}}};

/// Hexahedron's edges: four along x, four along y, four along z, from the lower to the upper corner.
inline constexpr std::array<std::array<int, 2>, 12> hexahedron_edges = {
    {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};
inline constexpr std::array<std::array<int, 2>, 6> tetrahedron_edges = {
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// The six paths along the axes from a hexahedron's lowest corner to its highest (Kuhn), tetrahedra by the corners.
/// Where neighbours' axes run alike, diagonals run from lower to upper corners on both sides of every face and the mesh
/// conforms. On the paths of odd permutations the first and third corner change places: that makes the volume positive
/// and keeps the opposite pairs {0, 2}, {1, 3} between which red refinement puts its diagonal.
inline constexpr std::array<std::array<int, 4>, 6> kuhn_tetrahedra = {
    {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {5, 1, 0, 7}, {3, 2, 0, 7}, {6, 4, 0, 7}}};

constexpr const std::array<int, 4>& face_corners(CellShape shape, int face) {
  return shape == CellShape::hexahedron ? hexahedron_faces[face] : tetrahedron_faces[face];
}
constexpr const std::array<int, 2>& edge_corners(CellShape shape, int edge) {
  return shape == CellShape::hexahedron ? hexahedron_edges[edge] : tetrahedron_edges[edge];
}

/// vtk_corner_order[k] is our corner that VTK and gmsh list as their k-th; for a hexahedron. A permutation of order 2.
inline constexpr std::array<int, 8> vtk_corner_order = {0, 1, 3, 2, 4, 5, 7, 6};

/// Values of the shape functions; entries past the shape's corners are zero.
inline std::array<double, max_corners> shape_functions(CellShape shape, const Eigen::Vector3d& xi) {
  std::array<double, max_corners> N{};
  if (shape == CellShape::tetrahedron) {
    N = {1.0 - xi.x() - xi.y() - xi.z(), xi.x(), xi.y(), xi.z()};
    return N;
  }
  for (int c = 0; c < 8; ++c)
    N[c] = ((c & 1) ? xi.x() : 1.0 - xi.x()) * ((c & 2) ? xi.y() : 1.0 - xi.y()) * ((c & 4) ? xi.z() : 1.0 - xi.z());
  return N;
}

/// Derivatives of the shape functions by the natural coordinates, 3 × corners; columns past the corners are zero.
inline Eigen::Matrix<double, 3, max_corners> shape_gradients(CellShape shape, const Eigen::Vector3d& xi) {
  Eigen::Matrix<double, 3, max_corners> dN = Eigen::Matrix<double, 3, max_corners>::Zero();
  if (shape == CellShape::tetrahedron) {
    dN.col(0).setConstant(-1.0);
    dN.block<3, 3>(0, 1).setIdentity();
    return dN;
  }
  for (int c = 0; c < 8; ++c) {
    const double x = (c & 1) ? xi.x() : 1.0 - xi.x(), sx = (c & 1) ? 1.0 : -1.0;
    const double y = (c & 2) ? xi.y() : 1.0 - xi.y(), sy = (c & 2) ? 1.0 : -1.0;
    const double z = (c & 4) ? xi.z() : 1.0 - xi.z(), sz = (c & 4) ? 1.0 : -1.0;
    dN.col(c) = Eigen::Vector3d(sx * y * z, x * sy * z, x * y * sz);
  }
  return dN;
}

}  // namespace finegauge
