#pragma once

#include <functional>
#include <string>

namespace finegauge {

/// How a computation in a process of its own ended.
struct ApartResult {
  enum class End { done, stopped, too_long, crashed };
  End end = End::crashed;
  std::string bytes;  ///< what it returned; of other ends than `done` empty
  std::string why;    ///< one line; empty when done
};

/// compute() in a fork of this process, so that a crash, memory that runs out and work that does not end are failures
/// of this one computation, and all its memory is given back. What it throws is a crash with the exception's words.
/// `seconds`: that it may take; `interrupted`: asked ten times a second, true ends it.
ApartResult run_apart(
    const std::function<std::string()>& compute, double seconds,
    const std::function<bool()>& interrupted = [] { return false; });

/// A fork has none of the threads that OpenMP keeps waiting, and would wait for them for ever: they are given up first.
void end_openmp_threads();

}  // namespace finegauge
