#pragma once

namespace finegauge {

/// From now on the first SIGINT or SIGTERM only sets a flag, so that a computation can stop between two steps and keep
/// what it has; a second one ends the process at once.
void catch_interrupts();
/// The signal that came, or 0.
int interrupt_signal();

}  // namespace finegauge
