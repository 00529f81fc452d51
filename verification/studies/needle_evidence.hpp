#pragma once

#include <vector>

#include "verification/support/evidence.hpp"

namespace finegauge {

/// The needle against closed forms: beams on the problems that the literature tests beams with (beam_benchmarks.hpp),
/// the loads at which the phantom needle buckles, a force on a line (line_force.hpp), and what a needle pushes with
/// against what holds tissue and needle. Throws std::runtime_error where a problem has no solution to show.
Evidence needle_evidence(const EvidenceOptions& options);

/// A needle of E = 50 MPa, 1 mm in radius and 32 mm long, clamped at its base and pressed along itself.
enum class NeedleTip {
  free,
  pinned,  ///< free to turn, not to move across
  fixed    ///< neither
};
struct BucklingRow {
  NeedleTip tip = NeedleTip::free;
  double euler = 0.0;  ///< of the thin needle that does not shorten [N]
  double exact = 0.0;  ///< with shear and compression [N], exact_buckling_load
  std::vector<int> elements;
  std::vector<double> found;  ///< where the straight equilibrium's tangent loses its positive definiteness [N]
  double extrapolated = 0.0;  ///< from the last two to no length of elements, order 2 [N]
  int lost = 0;               ///< negative pivots beyond: both planes of bending at once
};
BucklingRow needle_buckling(NeedleTip tip, const std::vector<int>& elements);

/// Closed forms [N] with shear along the deflected axis (Engesser 1891; Timoshenko & Gere 1961, 2.17) and with the
/// length that the load leaves, s = 1 - P / EA: P s / (1 - P s / GA) = c EI / L². That is the formula of the elements'
/// own theory, whose axial force is that of the chord and whose shear is the angle between chord and section.
/// Haringx's, P (s + P / GA) = c EI / L², belongs to an axial force across the section; it is larger by (P / GA)² (1 -
/// 2 GA / EA).
double exact_buckling_load(NeedleTip tip);
double haringx_buckling_load(NeedleTip tip);  ///< free and fixed tips
/// Of a chain of that many elements, free and fixed tips: difference equations instead of differential ones. With the
/// element's stiffness EI / l [a, b; b, a] for its end rotations and κ = √c / n, P s l² / EI = (a² - b²) (1 - cos κ) /
/// (a + b cos κ): order 2, and without shear P (1 + κ² / 12 + κ⁴ / 360).
double exact_buckling_load_of_chain(NeedleTip tip, int elements);

/// A needle inserted into a soft block, held until nothing moves: three ways to one force [N].
struct ForceBalance {
  double contact = 0.0;        ///< of all contact points along the needle, as a frame reports it
  double base = 0.0;           ///< what drives the base
  double clamp = 0.0;          ///< what holds the block's far face: stiffness times displacement there
  double kinetic_share = 0.0;  ///< of the energy at the end
  double bend = 0.0;           ///< largest distance of the needle's nodes from its line at rest [m]
  int points = 0;              ///< in contact
  /// Largest over all frames, over the largest force: base minus contact minus the needle's change of momentum a step.
  double momentum_error = 0.0;
  double largest_inertia = 0.0;  ///< the needle's change of momentum a step, over the largest force
};
/// `offset` of the needle's line from the block's middle [m]; beside it the block bends the needle.
ForceBalance needle_force_balance(double offset);

}  // namespace finegauge
