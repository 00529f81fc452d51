#include "core/adapt/stress_recovery.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <span>

#include "core/adapt/patch_polynomial.hpp"
#include "core/parallel/for_parts.hpp"

namespace finegauge {

namespace {

std::span<const int> cells_at(const NodeCells& around, int node) {
  return {around.cells.data() + around.start[node], around.cells.data() + around.start[node + 1]};
}

/// Per node, whether it has a patch of its own: inside the body, does not hang, no cell around it is mostly empty.
std::vector<std::uint8_t> find_inner_nodes(const Discretization& d, const NodeCells& around) {
  std::vector<std::uint8_t> inner(d.mesh.node_count());
  for (int node = 0; node < d.mesh.node_count(); ++node)
    inner[node] = !d.hanging.hangs(node) && !d.mesh.on_boundary[node];
  if (d.mesh.fraction.empty()) return inner;
  for (int node = 0; node < d.mesh.node_count(); ++node)
    for (const int cell : cells_at(around, node))
      if (d.mesh.fraction[cell] < least_sampled_share) inner[node] = 0;
  return inner;
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
                               const VoigtColumns& values, PatchBasis most) {
  if (mesh.shape == CellShape::tetrahedron || most == PatchBasis::linear)
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

/// Of the cells around a node those that are sampled; all where none is. `buffer` holds them where they are fewer.
std::span<const int> sampled_cells(const Mesh& mesh, std::span<const int> cells, std::vector<int>& buffer) {
  if (mesh.fraction.empty()) return cells;
  buffer.clear();
  for (const int cell : cells)
    if (mesh.fraction[cell] >= least_sampled_share) buffer.push_back(cell);
  return buffer.empty() ? cells : std::span<const int>(buffer);
}

/// For each boundary node that does not hang: the inner nodes whose polynomials give its value.
struct Sources {
  std::vector<int> begin, end;  ///< per node, into `inner`; equal where there are none
  std::vector<int> inner;
  int beside = 0;  ///< inner[0] .. inner[beside - 1] share a cell with the node that they are for; the others do not
};

/// Calls visit(other) for the nodes that share a cell with `node`, itself included, repeatedly.
template <class Visit>
void visit_neighbours(const Mesh& mesh, const NodeCells& around, int node, Visit&& visit) {
  const int corners = corner_count(mesh.shape);
  for (const int cell : cells_at(around, node))
    for (int c = 0; c < corners; ++c) visit(mesh.cells[cell][c]);
}

Sources find_sources(const Discretization& d, const NodeCells& around, const std::vector<std::uint8_t>& inner) {
  const int node_count = d.mesh.node_count();
  Sources sources{std::vector<int>(node_count, 0), std::vector<int>(node_count, 0), {}};
  std::vector<int> last_user(node_count, -1);  // per inner node
  const auto add_beside = [&](int node, int user) {
    visit_neighbours(d.mesh, around, node, [&](int other) {
      if (!inner[other] || last_user[other] == user) return;
      last_user[other] = user;
      sources.inner.push_back(other);
    });
  };

  std::vector<int> without;
  for (int node = 0; node < node_count; ++node) {
    if (inner[node] || d.hanging.hangs(node)) continue;
    sources.begin[node] = static_cast<int>(sources.inner.size());
    add_beside(node, node);
    sources.end[node] = static_cast<int>(sources.inner.size());
    if (sources.begin[node] == sources.end[node]) without.push_back(node);
  }
  sources.beside = static_cast<int>(sources.inner.size());
  std::vector<int> last_relay(node_count, -1);  // per neighbour, hanging ones too
  for (const int node : without) {
    sources.begin[node] = static_cast<int>(sources.inner.size());
    visit_neighbours(d.mesh, around, node, [&](int neighbour) {
      if (last_relay[neighbour] == node) return;
      last_relay[neighbour] = node;
      add_beside(neighbour, node);
    });
    sources.end[node] = static_cast<int>(sources.inner.size());
  }
  return sources;
}

/// How far from its patch, in patch coordinates, the polynomial of an inner node that is not beside the node may be
/// evaluated: the cells of a regular patch reach to 2, one more layer of such cells to 4. A patch of small cells says
/// nothing about the far side of a large one.
constexpr double farthest_evaluation = 4.0;
/// Behind a layer of cells that are mostly empty that bound is where the nodes are: a tie, which round-off must not
/// decide.
constexpr double farthest_evaluation_behind_cut = farthest_evaluation * (1.0 + 0x1p-20);

/// Largest condition of a trilinear fit that is evaluated away from its node; past it the linear fit is.
constexpr double largest_extrapolated_condition = 100.0;

/// All that the recovery needs of a mesh, whatever the stress.
struct Patches {
  NodeCells around;
  Eigen::Matrix3Xd centres;         ///< of cells [m]
  std::vector<std::uint8_t> inner;  ///< per node
  Sources sources;
  std::vector<int> kept_as;  ///< per node the number of its polynomial, -1 where no other node evaluates it
  int kept_count = 0;
};

Patches patches_of(const Discretization& d) {
  Patches patches;
  patches.around = cells_around_nodes(d.mesh);
  patches.centres = cell_centres(d.mesh);
  patches.inner = find_inner_nodes(d, patches.around);
  patches.sources = find_sources(d, patches.around, patches.inner);
  patches.kept_as.assign(static_cast<std::size_t>(d.mesh.node_count()), -1);
  for (const int node : patches.sources.inner)
    if (patches.kept_as[node] < 0) patches.kept_as[node] = patches.kept_count++;
  return patches;
}

constexpr int least_per_thread = worth_a_thread(500);  // cells or nodes

/// Makes the stress at each node of the free surface P σ P.
void free_tractions(const FreeSurface& surface, const std::vector<Eigen::Matrix3d>& directions, VoigtColumns& nodal) {
  for (std::size_t k = 0; k < directions.size(); ++k) {
    const Eigen::Matrix3d sigma = stress_tensor(nodal.col(surface.nodes[k]));
    nodal.col(surface.nodes[k]) = voigt(directions[k] * sigma * directions[k]);
  }
}

/// Nodal values of stresses at the centres of the cells. `free_directions` may be empty: then no traction is known.
VoigtColumns recover(const Discretization& d, const Patches& patches, const VoigtColumns& at_centres, PatchBasis most,
                     const std::vector<Eigen::Matrix3d>& free_directions) {
  const Mesh& mesh = d.mesh;
  const Sources& sources = patches.sources;
  // Only polynomials that other nodes evaluate are kept.
  std::vector<PatchPolynomial> kept(static_cast<std::size_t>(patches.kept_count));
  const double farthest = mesh.fraction.empty() ? farthest_evaluation : farthest_evaluation_behind_cut;
  VoigtColumns nodal(6, mesh.node_count());
  for_parts(mesh.node_count(), least_per_thread, [&](int first, int last) {
    for (int node = first; node < last; ++node) {
      if (!patches.inner[node]) continue;
      const auto cells = cells_at(patches.around, node);
      PatchPolynomial p = fit_inner_node(mesh, cells, node, patches.centres, at_centres, most);
      nodal.col(node) = p(mesh.nodes.col(node));
      if (patches.kept_as[node] < 0) continue;
      if (p.basis == PatchBasis::trilinear && p.condition > largest_extrapolated_condition)
        p = fit_patch(cells, patches.centres, at_centres, Eigen::Matrix3d::Identity(), PatchBasis::linear);
      kept[patches.kept_as[node]] = p;
    }
  });
  for_parts(mesh.node_count(), least_per_thread, [&](int first, int last) {
    std::vector<int> buffer;
    for (int node = first; node < last; ++node) {
      if (d.hanging.hangs(node) || patches.inner[node]) continue;
      const Eigen::Vector3d X = mesh.nodes.col(node);
      Voigt sum = Voigt::Zero();
      int count = 0;
      for (int k = sources.begin[node]; k < sources.end[node]; ++k) {
        const PatchPolynomial& p = kept[patches.kept_as[sources.inner[k]]];
        if (k >= sources.beside && !(p.distance(X) <= farthest)) continue;
        sum += p(X);
        ++count;
      }
      nodal.col(node) = count > 0
                            ? Voigt(sum / static_cast<double>(count))
                            : fit_patch(sampled_cells(mesh, cells_at(patches.around, node), buffer), patches.centres,
                                        at_centres, Eigen::Matrix3d::Identity(), PatchBasis::linear)(X);
    }
  });
  free_tractions(d.free_surface, free_directions, nodal);
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

}  // namespace

CellStresses cell_stresses(const Discretization& d, const Eigen::Matrix3Xd& u) {
  const Mesh& mesh = d.mesh;
  const Material& material = d.shapes.material();
  const int points = quadrature_count(mesh.shape);
  CellStresses stresses;
  stresses.centre.resize(6, mesh.cell_count());
  stresses.quadrature.resize(6, static_cast<Eigen::Index>(mesh.cell_count()) * points);
  for_parts(mesh.cell_count(), least_per_thread, [&](int first, int last) {
    CellGeometry scratch;
    for (int cell = first; cell < last; ++cell) {
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
  });
  return stresses;
}

VoigtColumns recover_stress_spr(const Discretization& d, const CellStresses& stresses, PatchBasis most) {
  return recover(d, patches_of(d), stresses.centre, most, {});
}

VoigtColumns recover_stress_twice(const Discretization& d, const CellStresses& stresses,
                                  const std::vector<Eigen::Matrix3d>& free_directions) {
  const Patches patches = patches_of(d);
  const auto recover_once = [&](const VoigtColumns& at_centres) {
    return recover(d, patches, at_centres, PatchBasis::trilinear, free_directions);
  };
  const VoigtColumns once = recover_once(stresses.centre);
  const int corners = corner_count(d.mesh.shape);
  VoigtColumns recovered(6, d.mesh.cell_count());
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    Voigt sum = Voigt::Zero();
    for (int c = 0; c < corners; ++c) sum += once.col(d.mesh.cells[cell][c]);
    recovered.col(cell) = sum / corners;
  }
  return 2.0 * once - recover_once(recovered);
}

}  // namespace finegauge
