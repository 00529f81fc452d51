#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/adapt/stress_recovery.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Estimated error in the energy norm. Integrals are over the material: a cell counts by its share of it (the stiffness
/// that slivers keep beyond that is no part of the body), so that a cell without material has η_e = 0. Where it is
/// known in which part of a cell the material lies, η_e is weighted there; its direction is that of the whole cell.
struct ErrorEstimate {
  Eigen::VectorXd eta;  ///< per cell, sqrt ∫ (ε_h - ε_s):(σ_h - σ_s) [√J] (paper, eq. of η_e); spr_edges: more, below
  Eigen::Matrix3Xd direction;  ///< per cell, share of η_e² along each of its axes, columns sum to one
  double total = 0.0;          ///< sqrt Σ η_e² [√J]
  double energy_norm = 0.0;    ///< sqrt ∫ ε_h:σ_h [√J]
  double relative = 0.0;       ///< η = total / energy_norm; zero when both vanish
  Eigen::Matrix<double, 6, Eigen::Dynamic> nodal_stress;  ///< the recovered stress [Pa], 6 × n_nodes
};

/// How the error is estimated.
enum class Estimator {
  spr,       ///< superconvergent patch recovery, as the paper has it
  spr_edges  ///< the same of a stress recovered twice over, in tetrahedra without traction on free surfaces, with the
             ///< cells at singular edges weighted and what the solution lacks as a whole added
};

/// The share along axis i is the energy of the part of σ_h - σ_s that is odd in the natural coordinate i: the strain
/// that one more node along i would let the cell follow. Equal shares where all three vanish, and for tetrahedra.
ErrorEstimate estimate_error_spr(const Discretization& d, const Eigen::Matrix3Xd& u);

/// What Estimator::spr_edges adds to η_e² in the cells that touch a singular edge (space/singular_edges.hpp), where no
/// polynomial follows the unbounded stress: min((w - 1) η_e², c E_e), E_e the cell's ∫ ε_h:σ_h. In the field r^λ of the
/// edge alone both are the error that the recovery misses: error and energy scale alike there, on every mesh. Elsewhere
/// each holds the other back: cells that lock or are bent show an error of their own, which the recovery does follow
/// and which must not be multiplied, and a stress that is not singular has energy of its own.
///
/// Calibrated against the exact fields of cracks, notches and clamped rims (verification/studies/estimator_ladder.hpp)
/// for the whole error, a few percent to the safe side.
///
/// Hexahedra: w by the cells around the edge (two in a flat face, three in a notch, four at a crack), first the single
/// cell at the rim of a clamped face. What a rim lacks follows its exponent: exp(7.85 - 15.2 λ) to a tenth for nu from
/// 0.1 to 0.45, rounded up to c = exp(8 - 15.2 λ), and 3/4 of that where cells of mean dilatation do not lock; notches,
/// cracks and the edges of flat supports have 0.1 to 0.27.
///
/// Tetrahedra: two thirds of the error lie in those that touch the edge, half of that in those that do with a corner
/// alone. At a notch those with an edge along it show all of theirs where they lie on one of its faces, and a tenth of
/// their squares where they lie between, so that c is what bounds those; those with a corner show half. At a clamped
/// rim of one or two tetrahedra all lie on a face; w - 1 follows λ, and is less where only a corner touches the rim. A
/// rim that three or more share is weighed as a notch: of that no field was tried.
inline constexpr std::array<double, 4> singular_edge_weights = {5.1, 2.4, 2.5, 1.85};
inline constexpr double notch_energy_share = 0.25, rim_share_of_mean_dilatation = 0.75;
double rim_energy_share(double exponent);  ///< c
/// Of a tetrahedron with an edge along the singular one, and of one that touches it with a corner.
struct TetrahedronWeights {
  double along, at_corner;
};
inline constexpr TetrahedronWeights tetrahedra_at_notch = {30.0, 2.0};  ///< w; along: of those between its faces
TetrahedronWeights tetrahedra_notch_energy_share(double exponent);      ///< c
inline constexpr TetrahedronWeights share_of_rim_gain = {1.5, 0.4};     ///< of exp(4.1 - 5.28 λ) in w - 1
inline constexpr double tetrahedra_share_of_rim = 1.5;                  ///< of hexahedra's c

/// Pollution (Babuška, Strouboulis, Mathur, Upadhyay 1994): what is lost at a singular edge is also lost of the field
/// that the edge sends out, by h^2λ everywhere; at λ = 1/2 that is as much of the error in each cell, however far. No
/// recovery sees it, since σ_h is off smoothly: of the nodal interpolant of a crack's field far tetrahedra show all
/// their error, of the solution 0.6 of its squares. Most of that the weights at the edge make up for, in hexahedra all.
/// In tetrahedra they cannot on every mesh, since refinement takes from the edge's cells sooner than from the others:
/// those that touch no edge get a share p(λ) of their squares besides, the mean of p over the edge's cells by their
/// squares, but no more in all than p of five times the latter, since edges that matter little pollute little. Where it
/// is large, refining far from the edge does not remove it. Calibrated with the weights, at λ from 1/2.
double pollution_share(double exponent);  ///< p
inline constexpr double most_pollution_of_near = 5.0;

/// Amplitude: under loads alone ∫ σ:C⁻¹:σ_h = ‖u_h‖² (Galerkin). A recovered stress of the shape of σ is at its closest
/// (‖u_h‖/‖u‖)² σ, and its squared distance from σ_h then ‖e‖² ‖u_h‖²/‖u‖²: ‖e‖² = est² / (1 - est²/‖u_h‖²). Recovered
/// stresses of coarse solutions are close to that: a bent plate, two tetrahedra thick, whose error is as large as
/// ‖u_h‖ shows 71 % of it, and 103 % of it with the factor; a recovered stress with more of the amplitude is overrated,
/// at η = 30 % by 5 %. The quotient is taken as 3/4 at most. Where supports move the body alone, ∫ σ:C⁻¹:σ_h = ‖u‖² and
/// est² = ‖e‖²; where both do, nothing is added either. Nor in corotational kinematics: far from the linear case the
/// energies are not quadratic.
inline constexpr double largest_lost_amplitude = 0.75;

ErrorEstimate estimate_error(const Discretization& d, const Eigen::Matrix3Xd& u, Estimator estimator);

}  // namespace finegauge
