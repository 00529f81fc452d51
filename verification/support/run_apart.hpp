#pragma once

#include <functional>
#include <limits>
#include <string>

namespace finegauge {

/// How a computation in a process of its own ended.
struct ApartResult {
  enum class End { done, stopped, too_long, crashed, refused };  ///< refused: it threw a SceneError
  End end = End::crashed;
  std::string bytes;  ///< what it returned; of other ends than `done` empty
  std::string why;    ///< one line; empty when done
};

/// Sends a message to the process that waits for a computation.
using Say = std::function<void(const std::string&)>;

struct ApartOptions {
  /// Of processor time that it may take, whole ones, so that a busy machine fails nothing; or twenty times as many of
  /// wall time.
  double seconds = std::numeric_limits<double>::infinity();
  std::function<bool()> interrupted = [] { return false; };            ///< asked ten times a second, true ends it
  std::function<void(std::string)> heard = [](const std::string&) {};  ///< each message, in order, while it runs
};

/// compute(say) in a fork of this process, so that a crash, memory that runs out and work that does not end are
/// failures of this one computation, and all its memory is given back. What it throws is a crash with the exception's
/// words, or a refusal. It does not outlive this process.
ApartResult run_apart(const std::function<std::string(const Say&)>& compute, const ApartOptions& options);
/// The same of a computation that has nothing to say.
ApartResult run_apart(
    const std::function<std::string()>& compute, double seconds,
    const std::function<bool()>& interrupted = [] { return false; });

/// A fork has none of the threads that OpenMP keeps waiting, and would wait for them for ever: they are given up first.
void end_openmp_threads();

}  // namespace finegauge
