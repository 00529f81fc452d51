#include "core/adapt/stress_recovery.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <span>

#include "core/adapt/patch_polynomial.hpp"

namespace finegauge {

namespace {

bool is_inner(const Discretization& d, int node) { return !d.hanging.hangs(node) && !d.mesh.on_boundary[node]; }

std::span<const int> cells_at(const NodeCells& around, int node) {
  return {around.cells.data() + around.start[node], around.cells.data() + around.start[node + 1]};
}

Eigen::Matrix3Xd cell_centres(const Mesh& mesh) {
  const int corners = corner_count(mesh.shape);
  Eigen::Matrix3Xd centres(3, mesh.cell_count());
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int c = 0; c < corners; ++c) sum += mesh.nodes.col(mesh.cells[cell][c]);
    centres.col(cell) = sum / corners;
  }
  return centres;
}

/// Directions of a hexahedron's axes at its centre [m].
Eigen::Matrix3d cell_axes(const Mesh& mesh, int cell) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i) axes.col(i) += (((c >> i) & 1) ? 0.25 : -0.25) * mesh.nodes.col(mesh.cells[cell][c]);
  return axes;
}

/// Cell k in octant k around the node, where eight cells hold the node at eight different corners.
bool find_octants(const Mesh& mesh, std::span<const int> cells, int node, std::array<int, 8>& octants) {
  if (cells.size() != 8) return false;
  unsigned found = 0;
  for (const int cell : cells) {
    const auto& corners = mesh.cells[cell];
    const auto corner = std::find(corners.begin(), corners.end(), node) - corners.begin();
    octants[static_cast<std::size_t>(7 - corner)] = cell;
    found |= 1u << corner;
  }
  return found == 0xffu;
}

/// Whether the octants are those of the patch as a whole: base cells may number their corners in different directions.
bool octants_agree(const std::array<int, 8>& octants, const Eigen::Matrix3Xd& centres,
                   const Eigen::Matrix3d& linear_part) {
  const Eigen::Matrix3d to_axes = linear_part.inverse();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const int cell : octants) mean += centres.col(cell) / 8.0;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d y = to_axes * (centres.col(octants[k]) - mean);
    for (int i = 0; i < 3; ++i)
      if (!(((k >> i) & 1 ? y[i] : -y[i]) > 0.0)) return false;
  }
  return true;
}

PatchPolynomial fit_inner_node(const Mesh& mesh, std::span<const int> cells, int node, const Eigen::Matrix3Xd& centres,
                               const VoigtColumns& values) {
  if (mesh.shape == CellShape::tetrahedron)
    return fit_patch(cells, centres, values, Eigen::Matrix3d::Identity(), PatchBasis::linear);
  std::array<int, 8> octants;
  if (find_octants(mesh, cells, node, octants)) {
    OctantFit fit = fit_octants(octants, centres, values);
    if (fit.is_lattice) return fit.polynomial;
    if (octants_agree(octants, centres, fit.linear_part))
      return fit_patch(cells, centres, values, fit.linear_part, PatchBasis::trilinear);
  }
  return fit_patch(cells, centres, values, cell_axes(mesh, cells[0]), PatchBasis::trilinear);
}

/// For each node whose value others' polynomials give: which inner nodes those are.
struct Sources {
  std::vector<int> begin, end;  ///< per node, into `inner`; equal where there are none
  std::vector<int> inner;
};

/// Calls visit(other) for the nodes that share a cell with `node`, itself included, repeatedly.
template <class Visit>
void visit_neighbours(const Mesh& mesh, const NodeCells& around, int node, Visit&& visit) {
  const int corners = corner_count(mesh.shape);
  for (const int cell : cells_at(around, node))
    for (int c = 0; c < corners; ++c) visit(mesh.cells[cell][c]);
}

/// First the nodes that share a cell with an inner node, then layer by layer those that share a cell with the last
/// layer and take the union of its sources: the inner nodes nearest in cells.
Sources find_sources(const Discretization& d, const NodeCells& around) {
  const int node_count = d.mesh.node_count();
  Sources sources{std::vector<int>(node_count, 0), std::vector<int>(node_count, 0), {}};
  std::vector<int> last_user(node_count, -1);  // per inner node
  const auto add = [&](int inner_node, int user) {
    if (last_user[inner_node] == user) return;
    last_user[inner_node] = user;
    sources.inner.push_back(inner_node);
  };
  std::vector<std::uint8_t> inner(node_count);
  for (int node = 0; node < node_count; ++node) inner[node] = is_inner(d, node);

  std::vector<int> layer, next;
  bool all_reached = true;
  const auto add_nearest = [&](int node) {
    sources.begin[node] = static_cast<int>(sources.inner.size());
    visit_neighbours(d.mesh, around, node, [&](int other) {
      if (inner[other]) add(other, node);
    });
    sources.end[node] = static_cast<int>(sources.inner.size());
    if (sources.end[node] > sources.begin[node])
      layer.push_back(node);
    else if (!d.hanging.hangs(node))
      all_reached = false;
  };
  for (int node = 0; node < node_count; ++node)
    if (!inner[node] && !d.hanging.hangs(node)) add_nearest(node);
  if (all_reached) return sources;
  for (int node = 0; node < node_count; ++node)
    if (d.hanging.hangs(node)) add_nearest(node);

  constexpr int unreached = -1;
  std::vector<int> layer_of(node_count, unreached);
  for (int node = 0; node < node_count; ++node)
    if (inner[node]) layer_of[node] = 0;
  for (const int node : layer) layer_of[node] = 1;
  for (int depth = 1; !layer.empty(); ++depth) {
    next.clear();
    for (const int node : layer)
      visit_neighbours(d.mesh, around, node, [&](int other) {
        if (layer_of[other] != unreached) return;
        layer_of[other] = depth + 1;
        next.push_back(other);
      });
    for (const int node : next) {
      sources.begin[node] = static_cast<int>(sources.inner.size());
      visit_neighbours(d.mesh, around, node, [&](int other) {
        if (layer_of[other] != depth) return;
        for (int k = sources.begin[other]; k < sources.end[other]; ++k) add(sources.inner[k], node);
      });
      sources.end[node] = static_cast<int>(sources.inner.size());
    }
    layer.swap(next);
  }
  return sources;
}

}  // namespace

CellStresses cell_stresses(const Discretization& d, const Eigen::Matrix3Xd& u) {
  const Mesh& mesh = d.mesh;
  const Material& material = d.shapes.material();
  const int points = quadrature_count(mesh.shape);
  CellStresses stresses;
  stresses.centre.resize(6, mesh.cell_count());
  stresses.quadrature.resize(6, static_cast<Eigen::Index>(mesh.cell_count()) * points);
  CellGeometry scratch;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellGeometry& geometry = d.shapes.geometry(mesh, cell, scratch);
    CellVectors local = corner_values(mesh, cell, u);
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    if (material.kinematics == Kinematics::corotational) {
      // Measured from a corner: a cell far from the origin keeps its digits.
      CellVectors X = corner_values(mesh, cell, mesh.nodes);
      for (int c = corner_count(mesh.shape) - 1; c >= 0; --c) X.col(c) -= X.col(0);
      const CellVectors x = X + local;
      R = cell_rotation(geometry, material, x);
      local = R.transpose().lazyProduct(x) - X;
    }
    stresses.centre.col(cell) = centre_stress(mesh.shape, geometry, material, R, local);
    const Eigen::Matrix<double, 6, 8> at_points = quadrature_stress(mesh.shape, geometry, material, R, local);
    stresses.quadrature.middleCols(static_cast<Eigen::Index>(cell) * points, points) = at_points.leftCols(points);
  }
  return stresses;
}

VoigtColumns recover_stress_spr(const Discretization& d, const CellStresses& stresses) {
  const Mesh& mesh = d.mesh;
  const NodeCells around = cells_around_nodes(mesh);
  const Eigen::Matrix3Xd centres = cell_centres(mesh);
  const Sources sources = find_sources(d, around);

  // Only polynomials that other nodes evaluate are kept.
  std::vector<int> kept_as(mesh.node_count(), -1);
  int kept_count = 0;
  for (const int node : sources.inner)
    if (kept_as[node] < 0) kept_as[node] = kept_count++;
  std::vector<PatchPolynomial> kept(kept_count);
  VoigtColumns nodal(6, mesh.node_count());
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (!is_inner(d, node)) continue;
    const PatchPolynomial p = fit_inner_node(mesh, cells_at(around, node), node, centres, stresses.centre);
    nodal.col(node) = p(mesh.nodes.col(node));
    if (kept_as[node] >= 0) kept[kept_as[node]] = p;
  }
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (d.hanging.hangs(node) || !mesh.on_boundary[node]) continue;
    const int begin = sources.begin[node], end = sources.end[node];
    if (begin == end) {  // a body without inner nodes
      const auto cells = cells_at(around, node);
      nodal.col(node) = fit_patch(cells, centres, stresses.centre, Eigen::Matrix3d::Identity(),
                                  PatchBasis::linear)(mesh.nodes.col(node));
      continue;
    }
    Voigt sum = Voigt::Zero();
    for (int k = begin; k < end; ++k) sum += kept[kept_as[sources.inner[k]]](mesh.nodes.col(node));
    nodal.col(node) = sum / static_cast<double>(end - begin);
  }
  const HangingNodes& T = d.hanging;
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (!T.hangs(node)) continue;
    Voigt sum = Voigt::Zero();
    for (int k = T.row_start[node]; k < T.row_start[node + 1]; ++k)
      sum += T.weight[k] * nodal.col(T.node_of[T.master[k]]);
    nodal.col(node) = sum;
  }
  return nodal;
}

}  // namespace finegauge
