#pragma once

#include "core/insertion_frame.hpp"

namespace finegauge {

struct [[nodiscard]] FrozenEquilibrium {
  double force = 0.0;  ///< all axial needle-tissue interaction at rest [N], as InsertionReport::force counts it
  double error = 0.0;  ///< equilibrium_error that is left
  int iterations = 0;  ///< of Newton
  bool converged = false;
};

/// Static equilibrium of tissue and needle with the base held where it is, and the contact's points and the state of
/// the tip frozen: no puncture, no cut. The shaft's friction keeps its law, from the present forces on: what slid may
/// stick as it settles. Loads that spread a change of the mesh do not act. It is one implicit step from rest, long
/// enough (10^6 time steps) that inertia and damping are without influence, by Newton's method.
FrozenEquilibrium frozen_equilibrium(const InsertionProblem& problem, const Insertion& insertion);

/// The same run at the same place: all but buffers and the solver's factor, which only preconditions.
Insertion copy_of(const Insertion& insertion, const InsertionProblem& problem);

}  // namespace finegauge
