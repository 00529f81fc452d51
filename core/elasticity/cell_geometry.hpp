#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/elasticity/material.hpp"
#include "core/mesh/mesh.hpp"

namespace finegauge {

/// Quadrature points of a cell: 2×2×2 Gauss for the hexahedron (point q at the natural coordinates of corner q drawn
/// towards the centre), one for the tetrahedron, whose gradients are constant.
constexpr int quadrature_count(CellShape shape) { return shape == CellShape::hexahedron ? 8 : 1; }
Eigen::Vector3d quadrature_point(CellShape shape, int q);

using Gradients = Eigen::Matrix<double, 3, max_corners>;    ///< column a: gradient of N_a by X [1/m]
using CellMatrix = Eigen::Matrix<double, 24, 24>;           ///< 3 × 3 blocks by corners; tetrahedra use 12 × 12
using CellVectors = Eigen::Matrix<double, 3, max_corners>;  ///< a vector per corner; unused columns are zero

/// All that a cell's mechanics needs of its rest shape.
struct CellGeometry {
  std::array<Gradients, 8> gradients;  ///< at the quadrature points
  Gradients centre_gradients;          ///< at the centre
  Gradients mean_gradients;            ///< averaged over the volume: the B-bar dilatation
  std::array<double, 8> weights;       ///< quadrature weight × det J [m³]; |det J| for tetrahedra
  double volume;                       ///< sum of the weights [m³]
};
CellGeometry cell_geometry(CellShape shape, const CellVectors& corners);

/// Stiffness at rest [N/m]:
///   K_ab = Σ_q w [ mu (g_b g_aᵀ + (g_a·g_b) I) - 2/3 mu g_a g_bᵀ ] + bulk × (Σ_q w g_a g_bᵀ, or V ḡ_a ḡ_bᵀ for
///   Dilatation::mean),  g = gradients of the shape functions. Tetrahedra have constant gradients: both agree.
CellMatrix cell_stiffness(CellShape shape, const CellGeometry& geometry, const Material& material);

/// Gradients averaged over the material of a hexahedron that is a box along the axes, corners in order: what ∮ N n dA
/// over the material's surface, walls of the cell included, is by the divergence theorem.
Gradients material_gradients(const CellVectors& corners, const MaterialMeans& means);

/// Stiffness [N/m] of a cell that is filled in part. A cell's energy has a part of the mean strain and one of
/// what the strain varies by:
///   K = s V B̄ᵀ D B̄ + s (K_full - V B̄_fᵀ D B̄_f) + max(0, s_min - s) K_full,
/// s the share of material, B̄ from the gradients averaged over the material and B̄_f over the whole cell, s_min
/// least_stiffness_share. All parts are positive semidefinite, however the surface cuts, and only rigid motions have no
/// energy. A body under uniform stress, loaded on its true surface, is exact (but for the part of s_min). Had the share
/// alone scaled K_full, as if the material lay evenly, the cells at the surface would be out of balance by as much as
/// their stress: a layer with errors of order one, and an energy error that falls with the root of the cell size only.
/// Varying strain counts as if the material lay evenly: a term of second order.
CellMatrix partial_stiffness(const CellGeometry& geometry, const CellMatrix& full, const Gradients& average,
                             double share, const Material& material);

/// Rest shapes of a mesh. Cells that are translates of one another (to 2^-42 of their size) share one entry, which is
/// what makes the assembly of refined boxes cheap; a shape that only one cell has is not kept but computed on use.
/// Of shared shapes the first cell in mesh order is the representative, so nothing depends on history.
class RestShapes {
 public:
  struct Entry {
    CellGeometry geometry;
    CellMatrix stiffness;
  };
  /// A cell as it is: its geometry, and its stiffness, partial_stiffness where it is not full. Here the share of
  /// material enters all elastic forces; mass, body forces and the estimate take it from the mesh.
  struct CellView {
    const CellGeometry& geometry;
    const CellMatrix& stiffness;
  };
  RestShapes() = default;
  RestShapes(const Mesh& mesh, const Material& material);

  /// Shared, or computed into `scratch`; the view lasts until `scratch` is used again.
  CellView entry(const Mesh& mesh, int cell, Entry& scratch) const;
  /// Geometry alone, for stages that need no stiffness. With Dilatation::mean a cell that is filled in part has the
  /// gradients averaged over its material for its mean ones: in its stiffness the bulk modulus acts on these.
  const CellGeometry& geometry(const Mesh& mesh, int cell, CellGeometry& scratch) const;
  const Material& material() const { return material_; }
  int shared_count() const { return static_cast<int>(shared_.size()); }

 private:
  /// partial_stiffness of a cell from that of a full one of its shape.
  CellMatrix stiffness_of(const Mesh& mesh, int cell, const CellGeometry& geometry, const CellMatrix& full) const;

  Material material_;
  std::vector<int> shared_of_;  // per cell; -1 where the shape is the cell's own
  std::vector<Entry> shared_;
};

/// Positions of a cell's corners from nodal values, 3 × corners.
inline CellVectors corner_values(const Mesh& mesh, int cell, const Eigen::Ref<const Eigen::Matrix3Xd>& nodal) {
  CellVectors values = CellVectors::Zero();
  for (int c = 0; c < corner_count(mesh.shape); ++c) values.col(c) = nodal.col(mesh.cells[cell][c]);
  return values;
}

}  // namespace finegauge
