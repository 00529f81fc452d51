#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "core/elasticity/material.hpp"
#include "core/mesh/base_mesh.hpp"

namespace finegauge {

/// Linear isotropic elasticity on a tensor product of intervals less a block of cells, by Lagrange elements of any
/// order. Only for reference solutions: it shares the block matrix and the direct solver with the core, but not the
/// mesh, the shape functions, the quadrature or the assembly, so that the two check each other at order one.
struct BoxElementProblem {
  std::array<std::vector<double>, 3> coordinates;  ///< cell boundaries [m] per axis, ascending
  std::optional<RemovedBlock> removed;             ///< lattice cells left out
  int order = 1;                                   ///< polynomial degree in each variable, 1 to 8
  Material material;                               ///< linear kinematics and standard dilatation are assumed
  /// Which components of the displacement are zero at a point on the grid; coordinates of cell boundaries are exact.
  std::function<std::array<bool, 3>(const Eigen::Vector3d&)> held;
  Eigen::Vector3d traction = Eigen::Vector3d::Zero();  ///< [Pa], on the whole of the lowest plane x
};

struct BoxElementSolution {
  int cells = 0;
  int dofs = 0;                    ///< 3 × nodes, held ones included
  double energy = 0.0;             ///< ∫ ε:σ [J]; a lower bound, as only homogeneous supports occur
  double relative_residual = 0.0;  ///< of the direct solve; the energy is off by about its square
};
/// Throws std::invalid_argument on an order out of range and std::runtime_error when the body is not held.
BoxElementSolution solve_box_elements(const BoxElementProblem& problem);

}  // namespace finegauge
