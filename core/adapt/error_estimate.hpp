#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/adapt/stress_recovery.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Estimated error in the energy norm. Integrals are over the material: a cell counts by its share of it (the stiffness
/// that slivers keep beyond that is no part of the body), so that a cell without material has η_e = 0. Where it is
/// known in which part of a cell the material lies, η_e is weighted there; its direction is that of the whole cell.
struct ErrorEstimate {
  Eigen::VectorXd eta;         ///< per cell, sqrt ∫ (ε_h - ε_s):(σ_h - σ_s) [√J] (paper, eq. of η_e)
  Eigen::Matrix3Xd direction;  ///< per cell, share of η_e² along each of its axes, columns sum to one
  double total = 0.0;          ///< sqrt Σ η_e² [√J]
  double energy_norm = 0.0;    ///< sqrt ∫ ε_h:σ_h [√J]
  double relative = 0.0;       ///< η = total / energy_norm; zero when both vanish
  Eigen::Matrix<double, 6, Eigen::Dynamic> nodal_stress;  ///< the recovered stress [Pa], 6 × n_nodes
};

/// The share along axis i is the energy of the part of σ_h - σ_s that is odd in the natural coordinate i: the strain
/// that one more node along i would let the cell follow. Equal shares where all three vanish, and for tetrahedra.
ErrorEstimate estimate_error_spr(const Discretization& d, const Eigen::Matrix3Xd& u);

}  // namespace finegauge
