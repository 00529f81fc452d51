#pragma once

#include <span>
#include <vector>

#include "core/insertion_frame.hpp"

namespace finegauge {

/// What a change of the mesh did to the needle's force. A frame that changes the mesh is taken twice from where it
/// began, with the change and without; both then go on with the base held, and the difference of their forces, frame by
/// frame, is what the change did.
struct CheckedChange {
  int frame = 0;
  int refined = 0, coarsened = 0;
  double force = 0.0;         ///< in the frame [N]
  double asked = 0.0;         ///< equilibrium on the new mesh minus that on the old one (frozen_equilibrium) [N]
  double excess = 0.0;        ///< how far the difference leaves the interval from zero to `asked`, at most [N]
  double largest_step = 0.0;  ///< of the difference in one frame [N]
  double reached = 0.0;       ///< the difference in the last frame [N]
  int frames = 0;             ///< followed: those of the release and some more, or until a contact event
  bool judged = false;        ///< no contact event came with the change, and both equilibria were found
};

/// How many frames after a change's own N are followed.
inline constexpr int frames_after_release = 3;

/// One frame; what it does to the mesh is checked and added. The insertion goes on as by advance_frame.
InsertionReport advance_checked(const InsertionProblem& problem, Insertion& insertion,
                                std::vector<CheckedChange>& changes);

struct PoppingSummary {
  int changes = 0, judged = 0;
  double largest_excess = 0.0;  ///< of judged changes [N]
  double largest_step = 0.0;    ///< of judged changes [N]
  double largest_asked = 0.0;   ///< its magnitude, of judged changes [N]
};
PoppingSummary summarize(std::span<const CheckedChange> changes);

}  // namespace finegauge
