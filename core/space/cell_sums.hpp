#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/elasticity/cell_response.hpp"
#include "core/parallel/for_parts.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// A cell in a displaced body: its corners at rest and now [m], and its rotation. Without rotations only u counts, and
/// in X + u - X it would lose the digits that X has before it: X is then zero, and x is u.
struct CellMotion {
  CellVectors X, x;
  Eigen::Matrix3d R;
};
inline CellMotion cell_motion(const Discretization& d, int cell, const CellGeometry& geometry,
                              const Eigen::Matrix3Xd& u) {
  CellMotion motion;
  const bool turns = d.shapes.material().kinematics == Kinematics::corotational;
  motion.X = turns ? corner_values(d.mesh, cell, d.mesh.nodes) : CellVectors(CellVectors::Zero());
  motion.x = motion.X + corner_values(d.mesh, cell, u);
  motion.R = cell_rotation(geometry, d.shapes.material(), motion.x);
  return motion;
}

inline constexpr int cells_per_thread = worth_a_thread(300);

/// Nodal sums [3 × n_nodes] of what of_cell(cell, entry) gives for a cell's corners, as many as it gives; added in the
/// order of the cells, whatever the threads.
template <std::size_t fields, class OfCell>
std::array<Eigen::Matrix3Xd, fields> sum_over_cells(const Discretization& d, const OfCell& of_cell) {
  std::array<Eigen::Matrix3Xd, fields> sums;
  for (Eigen::Matrix3Xd& sum : sums) sum.setZero(3, d.mesh.node_count());
  const int cells = d.mesh.cell_count();
  const auto add = [&](int cell, const std::array<CellVectors, fields>& values) {
    for (int c = 0; c < corner_count(d.mesh.shape); ++c)
      for (std::size_t k = 0; k < fields; ++k) sums[k].col(d.mesh.cells[cell][c]) += values[k].col(c);
  };
  if (thread_count() == 1) {
    RestShapes::Entry scratch;
    for (int cell = 0; cell < cells; ++cell) add(cell, of_cell(cell, d.shapes.entry(d.mesh, cell, scratch)));
    return sums;
  }
  std::vector<std::array<CellVectors, fields>> values(static_cast<std::size_t>(cells));
  for_parts(cells, cells_per_thread, [&](int first, int last) {
    RestShapes::Entry scratch;
    for (int cell = first; cell < last; ++cell)
      values[static_cast<std::size_t>(cell)] = of_cell(cell, d.shapes.entry(d.mesh, cell, scratch));
  });
  for (int cell = 0; cell < cells; ++cell) add(cell, values[static_cast<std::size_t>(cell)]);
  return sums;
}

}  // namespace finegauge
