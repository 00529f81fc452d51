#include "core/space/lumped_mass.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace finegauge {
namespace {

/// ∫ N_c dV [m³] of a cell's corners, times its share of material. Exact for hexahedra too: along each axis N_c det J
/// is a cubic.
std::array<double, max_corners> corner_volumes(const Discretization& d, int cell, CellGeometry& scratch) {
  const CellShape shape = d.mesh.shape;
  const CellGeometry& geometry = d.shapes.geometry(d.mesh, cell, scratch);
  std::array<double, max_corners> volumes{};
  const double share = material_share(d.mesh, cell);
  for (int q = 0; q < quadrature_count(shape); ++q) {
    const std::array<double, max_corners> N = shape_functions(shape, quadrature_point(shape, q));
    for (int c = 0; c < corner_count(shape); ++c) volumes[c] += share * geometry.weights[q] * N[c];
  }
  return volumes;
}

/// add(i, T_ci × ∫ N_c dV) for the corners c of a cell and their masters i.
template <class Add>
void add_row_sums(const Discretization& d, int cell, CellGeometry& scratch, const Add& add) {
  const std::array<double, max_corners> volumes = corner_volumes(d, cell, scratch);
  for (int c = 0; c < corner_count(d.mesh.shape); ++c) {
    const int node = d.mesh.cells[cell][c];
    for (int k = d.hanging.row_start[node]; k < d.hanging.row_start[node + 1]; ++k)
      add(d.hanging.master[k], d.hanging.weight[k] * volumes[c]);
  }
}

/// add(i, part of the cell's volume of material [m³]) in proportion to ∫ φ_i² over the cell.
template <class Add>
void add_scaled_diagonal(const Discretization& d, int cell, CellGeometry& scratch, const Add& add) {
  const CellShape shape = d.mesh.shape;
  const int begin = d.scatter.node_start[cell], end = d.scatter.node_start[cell + 1];
  std::vector<double> square(end - begin, 0.0);
  const CellGeometry geometry = d.shapes.geometry(d.mesh, cell, scratch);
  double total = 0.0;
  for (int k = begin; k < end; ++k) {
    // Corner values of φ_i on the cell: a column of T.
    std::array<double, max_corners> corner{};
    for (int c = 0; c < corner_count(shape); ++c) {
      const int node = d.mesh.cells[cell][c];
      for (int w = d.hanging.row_start[node]; w < d.hanging.row_start[node + 1]; ++w)
        if (d.hanging.master[w] == d.scatter.nodes[k]) corner[c] = d.hanging.weight[w];
    }
    double& integral = square[k - begin];
    if (shape == CellShape::tetrahedron) {
      double sum = 0.0;
      for (const double value : corner) {
        sum += value;
        integral += value * value;
      }
      integral = geometry.volume / 20.0 * (integral + sum * sum);
    } else {
      for (int q = 0; q < quadrature_count(shape); ++q) {
        const std::array<double, max_corners> N = shape_functions(shape, quadrature_point(shape, q));
        double value = 0.0;
        for (int c = 0; c < max_corners; ++c) value += N[c] * corner[c];
        integral += geometry.weights[q] * value * value;
      }
    }
    total += integral;
  }
  const double material = material_share(d.mesh, cell) * geometry.volume;
  for (int k = begin; k < end; ++k) add(d.scatter.nodes[k], material * (square[k - begin] / total));
}

struct Lumping {
  Eigen::VectorXd volume;   // per reduced node [m³]
  std::vector<int> scaled;  // cells, ascending
};

Lumping lump(const Discretization& d) {
  Lumping lumping;
  std::vector<char> scaled(d.mesh.cell_count(), 0);
  CellGeometry scratch;
  // A scaled cell no longer makes up for what another one takes from a node, so there may be a second round; each
  // scales at least one cell more, and when all are scaled no mass is negative.
  for (bool again = true; again;) {
    again = false;
    lumping.volume = Eigen::VectorXd::Zero(d.hanging.reduced_count());
    Eigen::VectorXd magnitude = lumping.volume;
    const auto add = [&](int i, double volume) {
      lumping.volume[i] += volume;
      magnitude[i] += std::abs(volume);
    };
    for (int cell = 0; cell < d.mesh.cell_count(); ++cell)
      if (scaled[cell])
        add_scaled_diagonal(d, cell, scratch, add);
      else
        add_row_sums(d, cell, scratch, add);
    if (!((lumping.volume - least_share * magnitude).array() < 0.0).any()) break;
    for (int cell = 0; cell < d.mesh.cell_count(); ++cell)
      for (int k = d.scatter.node_start[cell]; k < d.scatter.node_start[cell + 1] && !scaled[cell]; ++k) {
        const int i = d.scatter.nodes[k];
        if (lumping.volume[i] < least_share * magnitude[i]) scaled[cell] = again = true;
      }
  }
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell)
    if (scaled[cell]) lumping.scaled.push_back(cell);
  return lumping;
}

}  // namespace

Eigen::VectorXd lumped_mass(const Discretization& d, double density) { return density * lump(d).volume; }

std::vector<int> cells_with_scaled_mass(const Discretization& d) { return lump(d).scaled; }

}  // namespace finegauge
