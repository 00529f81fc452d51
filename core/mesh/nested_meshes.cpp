#include "core/mesh/nested_meshes.hpp"

#include <Eigen/LU>
#include <stdexcept>
#include <string>

namespace finegauge {
namespace {

/// a - b; whole numbers, so exact before the conversion.
double difference(std::uint64_t a, std::uint64_t b) {
  return a >= b ? static_cast<double>(a - b) : -static_cast<double>(b - a);
}

/// Whether the outer leaf contains the inner one. Leaves of one base cell either do, or have no volume in common, or
/// come from templates that do not nest; whole numbers decide.
bool contains(CellShape shape, const LeafFrame& outer, const LeafFrame& inner) {
  if (outer.base_cell != inner.base_cell || outer.depth > inner.depth) return false;
  if (shape == CellShape::hexahedron) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint64_t lower = outer.corners[0][axis], size = outer.corners[1][axis];
      const std::uint64_t at = inner.corners[0][axis], length = inner.corners[1][axis];
      // No sums: they could pass 64 bits at the far end of the lattice.
      if (at < lower || at - lower > size || length > size - (at - lower)) return false;
    }
    return true;
  }
  // A tetrahedron's descendants have their corners in it, and no other leaf has its centroid there.
  const double tolerance = 1e-9;
  for (int corner = 0; corner < 4; ++corner) {
    const Eigen::Vector3d xi = natural_coordinates(shape, outer, inner.corners[corner]);
    if (xi.minCoeff() < -tolerance || xi.sum() > 1.0 + tolerance) return false;
  }
  return true;
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
  // contains the other, and the list with the smaller one moves on while it stays inside.
  const auto inside = [](const Mesh& outer, int a, const Mesh& inner, int b) {
    return b < inner.cell_count() && contains(outer.shape, outer.frames[a], inner.frames[b]);
  };
  int a = 0, b = 0;
  while (a < first.cell_count() && b < second.cell_count()) {
    if (inside(first, a, second, b)) {
      for (; inside(first, a, second, b); ++b) visit(a, b);
      ++a;
    } else if (inside(second, b, first, a)) {
      for (; inside(second, b, first, a); ++a) visit(a, b);
      ++b;
    } else {
      throw std::logic_error("visit_nested_leaves: leaf " + std::to_string(a) + " and leaf " + std::to_string(b) +
                             " do not contain one another");
    }
  }
  if (a != first.cell_count() || b != second.cell_count())
    throw std::logic_error("visit_nested_leaves: the meshes are not of one forest");
}

}  // namespace finegauge
