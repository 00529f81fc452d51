#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/needle/needle_equilibrium.hpp"
#include "verification/support/convergence.hpp"

namespace finegauge {

/// The needle's beams on the problems that the literature tests beams with. Every solve throws std::runtime_error when
/// it does not converge: without an equilibrium there is no row.

/// A clamped straight beam with a load across its tip, against P L³ / 3 EI + P L / k GA.
struct TimoshenkoRow {
  double slenderness = 0.0;  ///< length over radius of a round section
  int elements = 0;
  double linear = 0.0;       ///< relative error of one solve with the tangent at rest
  double equilibrium = 0.0;  ///< relative error of the equilibrium under a small load
};
inline constexpr double small_deflection = 1e-6;  ///< over length: the equilibrium's own nonlinearity is its square
TimoshenkoRow timoshenko_cantilever(double slenderness, int elements);

/// A clamped straight beam under a tip moment t EI / L, which bends it to a circle at t = 2π (Simo & Vu-Quoc 1986):
/// tip at L (sin t / t, (1 - cos t) / t).
struct RollUpRow {
  double t = 0.0;
  int elements = 0;
  double tip_error = 0.0;    ///< distance from the exact place over L
  double angle_error = 0.0;  ///< of the tip section [rad]
  int iterations = 0;
};
/// Planar: in the plane of bending. In space the symmetric part of the tangent is singular at t = π (the moment keeps
/// its axis, so that the skew part is what holds the beam there), and no load step may end on it.
RollUpRow roll_up(double t, int elements, int steps, bool planar = true);

/// Tip of an inextensible cantilever without shear under a dead load P across it, by elliptic integrals (Bisshopp &
/// Drucker 1945).
struct ElasticaTip {
  double w = 0.0, u = 0.0;  ///< deflection across and shortening along the rest axis, over L
  double angle = 0.0;       ///< [rad]
};
ElasticaTip exact_elastica(double load);  ///< P L² / EI > 0
/// The same with beam elements; EA is 1e8 EI / L², which shortens by less than 1e-8 `load`.
ElasticaTip beam_elastica(double load, int elements, int steps);
/// Errors of tip deflection, shortening and angle by the element's length over L.
std::vector<ErrorSeries> elastica_convergence(double load, const std::vector<int>& elements, int steps);

/// The 45° bend of Bathe & Bolourchi (1979): an arc of radius 100 in the plane z = 0, unit square section, E = 1e7,
/// nu = 0, clamped, with a dead load along z at its tip. Elements are straight, their nodes on the arc.
struct BendOptions {
  double load = 600.0;
  int chords = 16;             ///< sides of the polygon that stands for the arc
  int elements_per_chord = 1;  ///< more of them change the beam's discretization, not its geometry
  int steps = 8;
  double torsion_constant = 1.0 / 6.0;  ///< J; 0.140577 is the square's own
};
struct BendTip {
  Eigen::Vector3d position;
  int iterations = 0;
};
BendTip bend_45(const BendOptions& options);

/// Lee's frame (Lee, Manuel & Rossow 1968): legs of 120, hinged at their ends, A = 6, I = 2, E = 720, load 24 from the
/// corner. In the plane.
struct LeeLimit {
  double load = 0.0;                        ///< first maximum of the load on the equilibrium path
  double vertical = 0.0, horizontal = 0.0;  ///< displacement of the loaded point there
  int points = 0;                           ///< of the path up to its end
  int pivots_before = 0, pivots_after = 0;  ///< negative pivots of the tangent on the two sides of the maximum
};
LeeLimit lee_frame(bool shear, int elements_per_leg);

/// A clamped beam under a dead tip load whose base turns by full turns.
struct TurningBase {
  bool about_own_axis = true;  ///< a beam of rectangular section spins; otherwise it wheels about an axis across
  int turns = 3, steps_per_turn = 24, elements = 8;
};
struct TurningRow {
  double angle = 0.0;                             ///< of the base [rad]
  double energy = 0.0;                            ///< over EI / L
  double base_moment = 0.0;                       ///< size of the clamp's moment over EI / L
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();  ///< over L
};
std::vector<TurningRow> turning_base(const TurningBase& options);

}  // namespace finegauge
