#include "verification/support/cut_body.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "verification/support/sample_cells.hpp"

namespace finegauge {

namespace {

/// Share of the unit cube where m · ξ <= c, for m >= 0: the corners' cones taken in and out, Σ (-1)^|s| max(0, c -
/// s·m)^k / (k! Π m) over the k axes along which m is not negligible.
double share_of_unit_cube(const Eigen::Vector3d& m, double c) {
  std::vector<double> along;
  for (const double m_i : m)
    if (m_i > 1e-9 * m.maxCoeff()) along.push_back(m_i);
  const int k = static_cast<int>(along.size());
  double scale = 1.0, sum = 0.0;
  for (int i = 0; i < k; ++i) scale *= (i + 1) * along[i];
  for (int corner = 0; corner < (1 << k); ++corner) {
    double inside = c, sign = 1.0;
    for (int i = 0; i < k; ++i)
      if ((corner >> i) & 1) {
        inside -= along[i];
        sign = -sign;
      }
    if (inside > 0.0) sum += sign * std::pow(inside, k);
  }
  return std::clamp(sum / scale, 0.0, 1.0);
}

double ratio_of_eigenvalues(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().maxCoeff() / solver.eigenvalues().minCoeff();
}

}  // namespace

double share_of_box(const HalfSpace& half_space, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  Eigen::Vector3d m = half_space.normal.cwiseProduct(high - low);
  double c = half_space.offset - half_space.normal.dot(low);
  for (int axis = 0; axis < 3; ++axis)
    if (m[axis] < 0.0) {  // seen from the other end of the axis
      c -= m[axis];
      m[axis] = -m[axis];
    }
  return c <= 0.0 ? 0.0 : c >= m.sum() ? 1.0 : share_of_unit_cube(m, c);
}

std::vector<double> shares_in(const HalfSpace& half_space, const Mesh& mesh) {
  std::vector<double> shares(mesh.cells.size());
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    shares[cell] = share_of_box(half_space, mesh.nodes.col(mesh.cells[cell][0]), mesh.nodes.col(mesh.cells[cell][7]));
  return shares;
}

std::vector<MaterialMeans> means_in(const HalfSpace& half_space, const Mesh& mesh) {
  constexpr int parts = 8;
  std::vector<MaterialMeans> all(mesh.cells.size(), means_of_full_cell);
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const Eigen::Vector3d low = mesh.nodes.col(mesh.cells[cell][0]);
    const Eigen::Vector3d edges = (mesh.nodes.col(mesh.cells[cell][7]) - low) / parts;
    double sum = 0.0;
    MaterialMeans means{};
    for (int box = 0; box < parts * parts * parts; ++box) {
      const Eigen::Vector3d at =
          Eigen::Vector3i(box % parts, box / parts % parts, box / (parts * parts)).cast<double>();
      const Eigen::Vector3d from = low + at.cwiseProduct(edges);
      const double share = share_of_box(half_space, from, from + edges);
      const Eigen::Vector3d xi = (at.array() + 0.5) / parts;
      sum += share;
      for (int axis = 0; axis < 3; ++axis) {
        means[axis] += share * xi[axis];
        means[3 + axis] += share * xi[(axis + 1) % 3] * xi[(axis + 2) % 3];
      }
    }
    if (!(sum > 0.0)) continue;
    for (double& mean : means) mean /= sum;
    all[cell] = means;
  }
  return all;
}

BaseMesh reached_part(const HalfSpace& half_space, const BaseMesh& box) {
  BaseMesh part{.shape = box.shape, .nodes = {}, .cells = {}, .surfaces = {}, .regions = {}, .body = {}};
  std::vector<int> new_cell(box.cells.size(), -1), new_node(static_cast<std::size_t>(box.nodes.cols()), -1);
  std::vector<int> nodes;
  for (std::size_t cell = 0; cell < box.cells.size(); ++cell) {
    std::array<int, max_corners> corners = box.cells[cell];
    if (share_of_box(half_space, box.nodes.col(corners[0]), box.nodes.col(corners[7])) == 0.0) continue;
    new_cell[cell] = static_cast<int>(part.cells.size());
    for (int& node : corners) {
      if (new_node[node] < 0) {
        new_node[node] = static_cast<int>(nodes.size());
        nodes.push_back(node);
      }
      node = new_node[node];
    }
    part.cells.push_back(corners);
  }
  part.nodes = box.nodes(Eigen::all, nodes);
  for (const auto& [name, faces] : box.surfaces)
    for (const BaseFace& face : faces)
      if (new_cell[face.cell] >= 0) part.surfaces[name].push_back({new_cell[face.cell], face.face});
  return part;
}

std::vector<double> random_shares(const Mesh& mesh, std::mt19937& generator) {
  std::vector<double> shares(mesh.cells.size());
  for (double& share : shares) {
    const unsigned kind = generator() % 3;
    const double between = 0.5 + 0.5 * random_number(generator);
    share = kind == 0 ? 0.0 : kind == 1 ? 1.0 : between;
  }
  return shares;
}

double material_volume(const Discretization& d) {
  double volume = 0.0;
  CellGeometry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell)
    volume += material_share(d.mesh, cell) * d.shapes.geometry(d.mesh, cell, scratch).volume;
  return volume;
}

std::vector<std::uint8_t> nodes_without_material(const Mesh& mesh) {
  std::vector<std::uint8_t> without(static_cast<std::size_t>(mesh.node_count()), 1);
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int c = 0; c < corner_count(mesh.shape); ++c)
      if (material_share(mesh, cell) > 0.0) without[mesh.cells[cell][c]] = 0;
  return without;
}

double scaled_condition(const BlockMatrix<double>& A) {
  const Eigen::MatrixXd dense = to_sparse(A).toDense();
  const Eigen::VectorXd scale = dense.diagonal().cwiseSqrt().cwiseInverse();
  return ratio_of_eigenvalues(scale.asDiagonal() * dense * scale.asDiagonal());
}

double condition(const BlockMatrix<double>& A) { return ratio_of_eigenvalues(to_sparse(A).toDense()); }

}  // namespace finegauge
