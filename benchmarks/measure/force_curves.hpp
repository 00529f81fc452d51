#pragma once

#include <vector>

namespace finegauge {

/// A place where the tissue gave way.
struct ForcePeak {
  double travel;  ///< [m]
  double force;   ///< of the whole needle [N]
};
/// Where the tip's force passes its strength between two frames, linear between them: a frame notices it up to a
/// frame's rise of the force later. `margin`: force minus strength, before and after [N]. The later frame itself where
/// the margin did not rise through zero.
ForcePeak passing_point(double margin_before, ForcePeak before, double margin_after, ForcePeak after);

/// Force over the travel of the tip during insertion: one point a frame, with the places where the tissue gave way.
struct ForceCurve {
  std::vector<double> travel;    ///< of the tip since first touch, ascending but for round-off [m]
  std::vector<double> force;     ///< [N]
  std::vector<ForcePeak> peaks;  ///< of the cuts, in order
  int puncture = -1;             ///< index of the first puncture's frame; -1: none
};

/// Slope of the force from a fifth to four fifths of the force at puncture, by least squares [N/m]; NaN without three
/// points there (a surface without strength).
double stiffness_before_puncture(const ForceCurve& curve);

/// The line through the force's peaks: what the needle needs at most on its way to a depth.
struct Envelope {
  std::vector<double> travel, force;

  double at(double x) const;  ///< linear between the peaks; x within the first and the last
};
Envelope upper_envelope(const ForceCurve& curve);

/// ‖a - b‖ / ‖b‖ in L² over the travel that both envelopes cover, at `samples` equally spaced places; NaN where they
/// have less than two peaks or no common travel.
double envelope_distance(const ForceCurve& a, const ForceCurve& b, int samples = 400);
/// The same of the forces themselves, from touch to the smaller of the two last travels. The phase of stick and cut
/// dominates it.
double rms_distance(const ForceCurve& a, const ForceCurve& b, int samples = 2000);
/// Root mean square of F_a - F_b over the travel from touch on that both have [N]; NaN where they have none.
double force_difference(const ForceCurve& a, const ForceCurve& b, int samples = 2000);

/// The frames up to the deepest one, and those from it on, turned round so that their travel ascends too.
ForceCurve way_in(const ForceCurve& curve);
ForceCurve way_back(const ForceCurve& curve);
/// ∮ F dx over the travel of the tip [J]: what an insertion and its withdrawal take.
double loop_area(const ForceCurve& curve);

}  // namespace finegauge
