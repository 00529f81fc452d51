#include "verification/studies/popping.hpp"

#include <algorithm>
#include <cmath>

#include "verification/support/frozen_equilibrium.hpp"

namespace finegauge {
namespace {

/// The problem with the base at rest where it is at `time`, on a mesh that stays.
InsertionProblem held(const InsertionProblem& problem, double time) {
  InsertionProblem result = problem;
  result.motion.adapt.reset();
  result.motion.estimate_error = false;
  // Over all the time so far: the speed that constraints are measured by stays of its order.
  result.drive.strokes = {{base_displacement(problem.drive, time), time}};
  return result;
}

}  // namespace

InsertionReport advance_checked(const InsertionProblem& problem, Insertion& insertion,
                                std::vector<CheckedChange>& changes) {
  const Insertion start = copy_of(insertion, problem);
  InsertionReport report = advance_frame(problem, insertion);
  if (report.frame.refined == 0 && report.frame.coarsened == 0) return report;
  CheckedChange change;
  change.frame = report.frame.frame;
  change.refined = report.frame.refined;
  change.coarsened = report.frame.coarsened;
  change.force = report.force;

  InsertionProblem on_old_mesh = problem;
  on_old_mesh.motion.adapt.reset();
  Insertion old_twin = copy_of(start, problem), new_twin = copy_of(insertion, problem);
  static_cast<void>(advance_frame(on_old_mesh, old_twin));
  const FrozenEquilibrium before = frozen_equilibrium(problem, old_twin);
  const FrozenEquilibrium after = frozen_equilibrium(problem, new_twin);
  change.asked = after.force - before.force;

  const InsertionProblem holds = held(problem, insertion.tissue.time);
  const int frames = std::max(problem.motion.adapt->release, 1) + frames_after_release;
  double last = 0.0;
  bool converged = before.converged && after.converged;
  for (; change.frames < frames; ++change.frames) {
    const InsertionReport a = advance_frame(holds, old_twin), b = advance_frame(holds, new_twin);
    if (!a.events.empty() || !b.events.empty()) break;
    converged = converged && a.frame.converged && b.frame.converged;
    const double difference = b.force - a.force;
    const double low = std::min(0.0, change.asked), high = std::max(0.0, change.asked);
    change.excess = std::max({change.excess, difference - high, low - difference});
    change.largest_step = std::max(change.largest_step, std::abs(difference - last));
    last = difference;
  }
  change.reached = last;
  change.judged = converged && report.events.empty() && change.frames > 0;
  changes.push_back(change);
  return report;
}

PoppingSummary summarize(std::span<const CheckedChange> changes) {
  PoppingSummary summary;
  for (const CheckedChange& change : changes) {
    ++summary.changes;
    if (!change.judged) continue;
    ++summary.judged;
    summary.largest_excess = std::max(summary.largest_excess, change.excess);
    summary.largest_step = std::max(summary.largest_step, change.largest_step);
    summary.largest_asked = std::max(summary.largest_asked, std::abs(change.asked));
  }
  return summary;
}

}  // namespace finegauge
