#pragma once

#include <Eigen/Core>

#include "core/needle/needle.hpp"

namespace finegauge {

/// The needle's axis between the nodes. In each element a cubic with the nodes' positions and, as end derivatives by
/// the share, l_0 (d_i + γ): d_i = R_i R_e0 e_1 is the node's section normal and γ the shear angle of the
/// interdependent interpolation, -Φ / (2 (1 + Φ)) (d_1 + d_2) across the chord. To first order in the local rotations
/// this is the deflection that the element's stiffness stands for; it is free of the frame where there is no shear,
/// turns with the needle, and is C¹ but for shear (and for the kinks of a chain that is curved at rest).

/// A place on the needle's axis: element and its share of the element's length, 0 at the base side.
struct CentrelinePoint {
  int element = 0;
  double share = 0.0;
};

inline CentrelinePoint needle_tip(const Needle& needle) { return {needle.element_count() - 1, 1.0}; }

/// [m].
Eigen::Vector3d centreline_position(const Needle& needle, const NeedleState& state, CentrelinePoint point);
/// Unit tangent, from base to tip.
Eigen::Vector3d centreline_tangent(const Needle& needle, const NeedleState& state, CentrelinePoint point);
/// Rest arc length from the base, along the chords [m].
double arc_length(const Needle& needle, CentrelinePoint point);
/// The inverse of arc_length; base and tip for lengths beyond them.
CentrelinePoint at_arc_length(const Needle& needle, double length);

/// The closest point of the axis to x. Every element is searched whose chord does not rule it out: the best of five
/// places in it, then Newton's method with bisection between its neighbours. (A cubic with two nearly equal minima
/// within a quarter of an element may yield either.) The first of equals, from the base.
struct ClosestPoint {
  CentrelinePoint point;
  double distance = 0.0;           ///< of x from that point [m]
  double distance_past_tip = 0.0;  ///< > 0 where x lies beyond the tip along the tangent there [m]
};
ClosestPoint closest_point(const Needle& needle, const NeedleState& state, const Eigen::Vector3d& x);

/// Velocity of the axis there from the generalized velocities of the element's two nodes: v = N (v_1 ω_1 v_2 ω_2),
/// 3 × 12. The exact derivative of centreline_position by the configuration, at a fixed share.
Eigen::Matrix<double, 3, 12> centreline_velocity(const Needle& needle, const NeedleState& state, CentrelinePoint point);

}  // namespace finegauge
