#include "core/mesh/nested_meshes.hpp"

#include <Eigen/LU>
#include <cmath>

namespace finegauge {
namespace {

/// a - b; whole numbers, so exact before the conversion.
double difference(std::uint64_t a, std::uint64_t b) {
  return a >= b ? static_cast<double>(a - b) : -static_cast<double>(b - a);
}

/// Share of the base cell that the leaf fills.
double share(CellShape shape, const LeafFrame& leaf) {
  if (shape == CellShape::tetrahedron) return std::pow(0.125, leaf.depth);
  const double unit = static_cast<double>(lattice_unit(shape));
  double size = 1.0;
  for (const std::uint64_t edge : leaf.corners[1]) size *= static_cast<double>(edge) / unit;
  return size;
}

}  // namespace

LatticePoint lattice_corner(CellShape shape, const LeafFrame& leaf, int corner) {
  if (shape == CellShape::tetrahedron) return leaf.corners[corner];
  LatticePoint point;
  for (int axis = 0; axis < 3; ++axis)
    point[axis] = leaf.corners[0][axis] + ((corner >> axis) & 1 ? leaf.corners[1][axis] : 0);
  return point;
}

Eigen::Vector3d natural_coordinates(CellShape shape, const LeafFrame& leaf, const LatticePoint& point) {
  Eigen::Vector3d xi;
  for (int axis = 0; axis < 3; ++axis) xi[axis] = difference(point[axis], leaf.corners[0][axis]);
  if (shape == CellShape::hexahedron) {
    for (int axis = 0; axis < 3; ++axis) xi[axis] /= static_cast<double>(leaf.corners[1][axis]);
    return xi;
  }
  Eigen::Matrix3d edges;
  for (int c = 0; c < 3; ++c)
    for (int axis = 0; axis < 3; ++axis) edges(axis, c) = difference(leaf.corners[c + 1][axis], leaf.corners[0][axis]);
  return edges.inverse() * xi;
}

void visit_nested_leaves(const Mesh& first, const Mesh& second, const std::function<void(int, int)>& visit) {
  // Both meshes list the leaves of a base cell in the same order, so of two leaves at the heads of the lists one
  // contains the other: the list with the smaller one moves on until the larger one is full.
  int a = 0, b = 0;
  while (a < first.cell_count() && b < second.cell_count()) {
    const double share_a = share(first.shape, first.frames[a]), share_b = share(second.shape, second.frames[b]);
    const double full = std::max(share_a, share_b) * (1.0 - 1e-9);
    if (share_a >= share_b) {
      for (double filled = 0.0; filled < full; ++b) {
        filled += share(second.shape, second.frames[b]);
        visit(a, b);
      }
      ++a;
    } else {
      for (double filled = 0.0; filled < full; ++a) {
        filled += share(first.shape, first.frames[a]);
        visit(a, b);
      }
      ++b;
    }
  }
}

}  // namespace finegauge
