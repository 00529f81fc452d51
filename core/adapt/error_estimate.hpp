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

/// How the error is estimated.
enum class Estimator {
  spr,       ///< superconvergent patch recovery, as the paper has it
  spr_edges  ///< the same, with the cells at singular edges weighted
};

/// The share along axis i is the energy of the part of σ_h - σ_s that is odd in the natural coordinate i: the strain
/// that one more node along i would let the cell follow. Equal shares where all three vanish, and for tetrahedra.
ErrorEstimate estimate_error_spr(const Discretization& d, const Eigen::Matrix3Xd& u);

/// Weights of η_e² of the cells that touch a singular edge (space/singular_edges.hpp), with which the whole error comes
/// out right: no polynomial that is recovered there follows an unbounded stress, so that plain SPR has some 0.7 of the
/// error of such cells, on every mesh, and 0.5 where a single cell fills the edge. Calibrated against the exact fields
/// of a notch, of a clamped face's rim and of a crack (verification/studies/estimator_ladder.hpp): 1.8 to 2.1, and 4.4.
inline constexpr double singular_edge_weight = 2.0, single_cell_edge_weight = 4.4;
ErrorEstimate estimate_error(const Discretization& d, const Eigen::Matrix3Xd& u, Estimator estimator);

/// Estimated over true error of Estimator::spr_edges on every rung of the ladder (verification/studies/
/// estimator_ladder.hpp), which gates it: smooth fields on regular, perturbed, flat and hanging cells, nu up to 0.4999,
/// notches, cracks and clamped rims, refined or not. The true error lies between η / high and η / low where a problem
/// is like these: linear strains, cells full of material, no needle.
struct EffectivityRange {
  double low, high;
};
inline constexpr EffectivityRange certified_effectivity = {0.95, 1.15};

}  // namespace finegauge
