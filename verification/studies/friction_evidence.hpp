#pragma once

#include <vector>

#include "verification/support/evidence.hpp"

namespace finegauge {

inline constexpr double gravity = 9.81;  ///< [m/s²], of the incline

/// Friction, cutting and their cycles against closed forms. Throws std::runtime_error where a frame does not converge.
///
/// The shaft's friction has two coefficients by direction (against advance, against withdrawal), not a static and a
/// kinetic one. A needle whose tip has to cut has both all the same: what it takes to start is the shaft's friction and
/// the cutting strength, what it takes to go on is the shaft's friction.
Evidence friction_evidence(const EvidenceOptions& options);

/// A block on an incline: a rigid needle that lies in a rigid channel, two contact points, the axis tilted so that
/// advance leads down. Its weight across the channel is what the lateral rows carry and friction multiplies.
struct InclineCase {
  double slope = 0.0;  ///< [rad], negative: advance leads up
  double friction_in = 0.5, friction_out = 0.1;
  double speed = 0.0;  ///< at the start, along the axis [m/s]
  int steps = 50;
};
struct InclineRow {
  bool sticks = false;        ///< both points, in the last step
  double acceleration = 0.0;  ///< of the steps together [m/s²]
  double speed = 0.0;         ///< at the end [m/s]
};
InclineRow slide_on_incline(const InclineCase& the_case);
/// The slope at which it starts to slide, by bisection [rad]; `down` the axis or up it.
double critical_slope(bool down, const InclineCase& the_case);

/// A needle pulled by a spring of stiffness k at speed V into a rigid channel: a stiff block behind a soft element.
struct StickSlip {
  double omega_tau = 0.0;  ///< of the block in its spring
  int cycles = 0;
  double period = 0.0, exact_period = 0.0;        ///< mean [s]
  double slip_time = 0.0, exact_slip_time = 0.0;  ///< mean [s]
  double drop = 0.0, exact_drop = 0.0;            ///< of the spring's force in a slip, mean [N]
  double drop_rate = 0.0;  ///< relative error of the drop by backward Euler's damping, over ω τ
  /// Of all cuts: spring's force minus cutting strength and shaft friction, over its increment a step.
  double least_excess = 0.0, most_excess = 0.0;
  int other_events = 0;  ///< beside cut, stick and the shaft's slip
  /// Against the same block by itself, a scalar in the same backward Euler: largest difference of the spring's force
  /// over the cutting strength, and steps in which only one of the two cuts or stops.
  double scalar_difference = 0.0;
  int scalar_mismatches = 0;
};
/// The block's inertia resolved: it slips until it stops, half an oscillation for V → 0.
StickSlip swinging_stick_slip(double tau, int cycles);
/// Steps far longer than the block's oscillation, no friction on the shaft: a slip takes all of the spring's force in
/// a step, and the period is that force over k V.
StickSlip creeping_stick_slip(int cycles);

/// In, rest, out and in by 6 mm, out: a needle in a rigid channel.
struct ChannelLoop {
  double force_error = 0.0;             ///< largest, of forces of a sliding needle against μ p depth, relative
  int sliding_out = 0, sliding_in = 0;  ///< frames that it is taken from
  double at_reversal = 0.0;             ///< force after over force before the first reversal
  double area = 0.0;                    ///< ∮ base force × way of the 6 mm [J]
  double dissipated = 0.0;              ///< by the ledger, over the same, and what the needle's strain differs by [J]
  double exact_area = 0.0;              ///< (μ_in + μ_out) p ∫ depth [J]
  double closure = 0.0, elastic = 0.0;  ///< of the whole ledger at the end, over the work
  double force_left = 0.0;              ///< after the exit [N]
  int points_left = 0;
};
ChannelLoop channel_loop();

/// Puncture, cuts and relaxations of a soft block.
struct CutCycle {
  int punctures = 0, cuts = 0;
  bool in_order = false;                       ///< touch, puncture, then cut and stick in turn
  double least_share = 0.0, most_share = 0.0;  ///< of a step's own increment by which a force is past its threshold
  double largest_increment = 0.0;              ///< of those steps, over the threshold
  double force_after = 0.0;                    ///< largest, two frames after a cut, over the force at the cut
  double risen = 0.0;  ///< least rise of the force between two cuts, over the force at the second
};
CutCycle cut_cycle();

}  // namespace finegauge
