#include "core/mesh/point_location.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/mesh/tetrahedron_children.hpp"

namespace finegauge {
namespace {

using Corners = Eigen::Matrix<double, 3, max_corners>;
using ChildMaps = std::array<Eigen::Matrix4d, 8>;

/// Barycentric coordinates in the child from those in the parent, each summing to one: the integer map as it stands.
const ChildMaps& tetrahedron_child_maps() {
  static const ChildMaps maps = [] {
    ChildMaps result;
    for (int child = 0; child < 8; ++child) {
      const auto map = tetrahedron_child_map(child);
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) result[child](i, j) = map[i][j];
    }
    return result;
  }();
  return maps;
}

/// How far a point lies outside of the reference cell along its worst direction; not positive inside.
double excess(CellShape shape, const Eigen::Vector3d& xi) {
  const double beyond = shape == CellShape::hexahedron ? xi.maxCoeff() : xi.sum();
  return std::max(-xi.minCoeff(), beyond - 1.0);
}

Eigen::Vector3d moved_inside(CellShape shape, const Eigen::Vector3d& xi) {
  if (shape == CellShape::hexahedron) return xi.cwiseMax(0.0).cwiseMin(1.0);
  const Eigen::Vector3d positive = xi.cwiseMax(0.0);
  return positive.sum() > 1.0 ? Eigen::Vector3d(positive / positive.sum()) : positive;
}

/// Number of the child that contains the point; xi becomes the point's natural coordinates in it.
int enter_child(CellShape shape, const RefinementTemplate& refinement, Eigen::Vector3d& xi) {
  if (shape == CellShape::hexahedron) {
    std::array<int, 3> at;
    for (int axis = 0; axis < 3; ++axis) {
      const int n = refinement.divisions[axis];
      at[axis] = std::clamp(static_cast<int>(xi[axis] * n), 0, n - 1);
      xi[axis] = xi[axis] * n - at[axis];
    }
    return at[0] + refinement.divisions[0] * (at[1] + refinement.divisions[1] * at[2]);
  }
  const Eigen::Vector4d parent(1.0 - xi.sum(), xi.x(), xi.y(), xi.z());
  Eigen::Vector4d best = Eigen::Vector4d::Constant(-std::numeric_limits<double>::infinity());
  int chosen = 0;
  for (int child = 0; child < 8; ++child) {
    const Eigen::Vector4d in_child = tetrahedron_child_maps()[child] * parent;
    if (!(in_child.minCoeff() > best.minCoeff())) continue;
    best = in_child;
    chosen = child;
  }
  xi = best.tail<3>();
  return chosen;
}

/// Whether leaf a comes before leaf b in the mesh: depth first, children in their order, which is that of their
/// handles.
bool precedes(const RefinementForest& forest, int a, int b) {
  const auto up = [&](int& handle) { handle = forest.cell(handle).parent; };
  while (forest.cell(a).depth > forest.cell(b).depth) up(a);
  while (forest.cell(b).depth > forest.cell(a).depth) up(b);
  while (forest.cell(a).parent != forest.cell(b).parent) up(a), up(b);
  return a < b;
}

/// ξ with Σ_c N_c(ξ) Y_c = 0 for a hexahedron, Newton's method from `xi`; false where it does not converge.
bool solve_map(const Corners& Y, Eigen::Vector3d& xi) {
  constexpr int iterations = 25;
  double last = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const auto N = shape_functions(CellShape::hexahedron, xi);
    Eigen::Vector3d residual = Eigen::Vector3d::Zero();
    for (int c = 0; c < 8; ++c) residual -= N[c] * Y.col(c);
    const Eigen::Matrix3d J = Y.lazyProduct(shape_gradients(CellShape::hexahedron, xi).transpose());
    const Eigen::Vector3d step = J.inverse() * residual;
    const double length = step.cwiseAbs().maxCoeff();
    if (!(length < 1e3)) return false;  // NaN, or a singular place
    xi += step;
    // Quadratic: past 1e-8 one more step is exact, and past that only round-off moves it.
    if (length < 1e-15 || (length < 1e-8 && !(length < 0.5 * last))) return true;
    last = length;
  }
  return last < 1e-8;
}

/// A point of a cell, and how far the point asked for is from it [m]; zero where only round-off tells them apart.
struct InCell {
  Eigen::Vector3d xi;
  double distance;
};

/// Where x is in a cell that contains it, to the slack; `size` bounds the coordinates for their round-off [m].
std::optional<InCell> coordinates_in_cell(CellShape shape, const Corners& corners, const Eigen::Vector3d& x,
                                          double size) {
  const int count = corner_count(shape);
  const Eigen::Vector3d middle = Eigen::Vector3d::Constant(shape == CellShape::hexahedron ? 0.5 : 0.25);
  const Eigen::Matrix3d J = corners.lazyProduct(shape_gradients(shape, middle).transpose());
  const Eigen::Matrix3d to_natural = J.inverse();
  if (!to_natural.allFinite()) return std::nullopt;
  const double rounding =
      32.0 * std::numeric_limits<double>::epsilon() * size * to_natural.cwiseAbs().rowwise().sum().maxCoeff();
  const double tolerance = location_slack + rounding;
  const auto moved = [&](const Eigen::Vector3d& xi) {
    const Eigen::Vector3d inside = moved_inside(shape, xi);
    return InCell{inside, excess(shape, xi) <= rounding ? 0.0 : (J * (xi - inside)).norm()};
  };
  // In the frame of the cell's own axes, x the origin: there the cell is nearly the unit cube however it is turned.
  Corners Y = Corners::Zero();
  for (int c = 0; c < count; ++c) Y.col(c) = to_natural * (corners.col(c) - x);
  if (shape == CellShape::tetrahedron) {
    const Eigen::Vector3d xi = -Y.col(0);
    if (!(excess(shape, xi) <= tolerance)) return std::nullopt;
    return moved(xi);
  }
  if ((Y.rowwise().minCoeff().array() > tolerance).any() || (Y.rowwise().maxCoeff().array() < -tolerance).any())
    return std::nullopt;
  Eigen::Vector3d xi = middle;
  const bool converged = solve_map(Y, xi);
  if (converged && excess(shape, xi) <= tolerance) return moved(xi);
  double bend = 0.0;  // of the edges from those of a parallelepiped
  for (int c = 0; c < 8; ++c)
    for (int axis = 0; axis < 3; ++axis)
      if (!((c >> axis) & 1))
        bend = std::max(bend, (Y.col(c | (1 << axis)) - Y.col(c) - Eigen::Vector3d::Unit(axis)).cwiseAbs().sum());
  // Half a cell around the cell the Jacobian differs from the identity by less than four times the bend, in a norm:
  // below one the map is one to one there, and the solution outside is the only one.
  if (converged && bend < 0.25 && excess(shape, xi) <= 0.5) return std::nullopt;
  for (int start = 0; start < 8; ++start) {
    xi = {(start & 1) ? 0.9 : 0.1, (start & 2) ? 0.9 : 0.1, (start & 4) ? 0.9 : 0.1};
    if (solve_map(Y, xi) && excess(shape, xi) <= tolerance) return moved(xi);
  }
  return std::nullopt;
}

/// The cell that contains x and the coordinates there. `position(node)` [m], `scale(node)` [m] bounds its round-off.
template <class Position, class Scale>
std::optional<LeafPoint> search_cells(CellShape shape, const std::vector<std::array<int, max_corners>>& cells,
                                      const Position& position, const Scale& scale, const Eigen::Vector3d& x,
                                      int hint) {
  const int count = corner_count(shape);
  const double extent = x.cwiseAbs().maxCoeff();
  if (!std::isfinite(extent)) return std::nullopt;
  const auto coordinates = [&](int cell) {
    Corners corners = Corners::Zero();
    for (int c = 0; c < count; ++c) corners.col(c) = position(cells[cell][c]);
    return coordinates_in_cell(shape, corners, x, extent + scale(cells[cell][0]));
  };
  const int cell_count = static_cast<int>(cells.size());
  if (hint >= 0 && hint < cell_count)
    if (const auto at = coordinates(hint); at && at->distance == 0.0) return LeafPoint{hint, at->xi};
  std::optional<LeafPoint> nearest;  // of those beside x
  double least = std::numeric_limits<double>::infinity();
  for (int cell = 0; cell < cell_count; ++cell) {
    // Along the axis on which its first corner is farthest, most cells lie wholly on one side of x.
    const auto& nodes = cells[cell];
    const Eigen::Vector3d first = position(nodes[0]) - x;
    int axis = 0;
    const double farthest = first.cwiseAbs().maxCoeff(&axis);
    const double side = first[axis] < 0.0 ? -1.0 : 1.0;
    double closest = farthest, most = farthest;
    for (int c = 1; c < count; ++c) {
      const double along = side * (position(nodes[c], axis) - x[axis]);
      closest = std::min(closest, along);
      most = std::max(most, along);
    }
    if (closest > 0.0 && closest > 2.0 * location_slack * most + 1e-14 * (extent + scale(nodes[0]))) continue;
    const auto at = coordinates(cell);
    if (!at) continue;
    if (at->distance == 0.0) return LeafPoint{cell, at->xi};
    if (at->distance < least) {
      least = at->distance;
      nearest = LeafPoint{cell, at->xi};
    }
  }
  return nearest;
}

struct RestPosition {
  const Eigen::Matrix3Xd& X;
  Eigen::Vector3d operator()(int node) const { return X.col(node); }
  double operator()(int node, int axis) const { return X(axis, node); }
};
struct CurrentPosition {
  const Eigen::Matrix3Xd& X;
  const Eigen::Matrix3Xd& u;
  Eigen::Vector3d operator()(int node) const { return X.col(node) + u.col(node); }
  double operator()(int node, int axis) const { return X(axis, node) + u(axis, node); }
};

}  // namespace

Eigen::Vector3d rest_position(const BaseMesh& base, const MaterialPoint& point) {
  const auto N = shape_functions(base.shape, point.xi);
  Eigen::Vector3d X = Eigen::Vector3d::Zero();
  for (int c = 0; c < corner_count(base.shape); ++c) X += N[c] * base.nodes.col(base.cells[point.base_cell][c]);
  return X;
}

LeafPoint find_leaf(const RefinementForest& forest, const Mesh& mesh, const MaterialPoint& point) {
  LeafPoint leaf{-1, point.xi};
  int handle = point.base_cell;
  while (!forest.is_leaf(handle)) {
    const auto& cell = forest.cell(handle);
    handle = cell.first_child + enter_child(mesh.shape, cell.refinement, leaf.xi);
  }
  const auto found = std::lower_bound(mesh.forest_cell.begin(), mesh.forest_cell.end(), handle,
                                      [&](int a, int b) { return precedes(forest, a, b); });
  assert(found != mesh.forest_cell.end() && *found == handle);
  leaf.cell = static_cast<int>(found - mesh.forest_cell.begin());
  leaf.xi = moved_inside(mesh.shape, leaf.xi);
  return leaf;
}

MaterialPoint material_point(const Mesh& mesh, const LeafPoint& point) {
  const LeafFrame& frame = mesh.frames[point.cell];
  const double unit = static_cast<double>(lattice_unit(mesh.shape));
  MaterialPoint result{frame.base_cell, Eigen::Vector3d::Zero()};
  if (mesh.shape == CellShape::hexahedron) {
    // From the nearer end, so that what lies on a face of the leaf does so exactly.
    const auto& [lower, size, unused_a, unused_b] = frame.corners;
    for (int axis = 0; axis < 3; ++axis) {
      const double length = static_cast<double>(size[axis]), xi = point.xi[axis];
      result.xi[axis] = (xi < 0.5 ? static_cast<double>(lower[axis]) + xi * length
                                  : static_cast<double>(lower[axis] + size[axis]) - (1.0 - xi) * length) /
                        unit;
    }
    return result;
  }
  const auto N = shape_functions(mesh.shape, point.xi);
  for (int c = 0; c < 4; ++c)
    for (int axis = 0; axis < 3; ++axis) result.xi[axis] += N[c] * static_cast<double>(frame.corners[c][axis]);
  result.xi = moved_inside(mesh.shape, result.xi / unit);
  return result;
}

Eigen::Vector3d interpolate(const Mesh& mesh, const Eigen::Matrix3Xd& nodal, const LeafPoint& point) {
  const auto N = shape_functions(mesh.shape, point.xi);
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (int c = 0; c < corner_count(mesh.shape); ++c) value += N[c] * nodal.col(mesh.cells[point.cell][c]);
  return value;
}

std::optional<MaterialPoint> locate_at_rest(const BaseMesh& base, const Eigen::Vector3d& X, int hint) {
  const auto scale = [&](int node) { return base.nodes.col(node).cwiseAbs().maxCoeff(); };
  const auto found = search_cells(base.shape, base.cells, RestPosition{base.nodes}, scale, X, hint);
  if (!found) return std::nullopt;
  return MaterialPoint{found->cell, found->xi};
}

std::optional<MaterialPoint> locate_deformed(const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::Vector3d& x,
                                             int hint) {
  const auto scale = [&](int node) {
    return mesh.nodes.col(node).cwiseAbs().maxCoeff() + u.col(node).cwiseAbs().maxCoeff();
  };
  const auto found = search_cells(mesh.shape, mesh.cells, CurrentPosition{mesh.nodes, u}, scale, x, hint);
  if (!found) return std::nullopt;
  return material_point(mesh, *found);
}

}  // namespace finegauge
