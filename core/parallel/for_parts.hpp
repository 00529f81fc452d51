#pragma once

#include <algorithm>

namespace finegauge {

/// How many threads share the loops over cells, nodes and rows, for the whole process; 1 until it is set, and always
/// where the library was built without OpenMP. Not to be set while anything computes. Results have the same bits for
/// any number: no sum is split between threads.
void set_thread_count(int count);
int thread_count();
/// Processors that this process may run on: more threads than that only wait for one another. 1 without OpenMP.
int processor_count();

namespace detail {

/// Calls part(body, first, last) for `parts` contiguous parts of [0, count) or fewer, on as many threads.
void run_parts(int count, int parts, void (*part)(const void* body, int first, int last), const void* body);

}  // namespace detail

/// How many items of a loop are worth a thread, one of which takes so long [ns]: 10 µs of them, several times what it
/// takes to start a thread that waits and to wait for it. The grain of for_parts.
constexpr int worth_a_thread(int nanoseconds_each) { return 10'000 / nanoseconds_each + 1; }

/// Calls body(first, last) for contiguous parts of [0, count) that together are the whole, at the same time on threads
/// that share the work, as many as there are parts of at least `grain`. What body writes must belong to its part alone
/// and must not depend on where the part ends. What it throws is thrown on, once all parts have ended.
template <class Body>
void for_parts(int count, int grain, const Body& body) {
  const int parts = std::min(thread_count(), count / std::max(1, grain));
  if (parts > 1)
    detail::run_parts(
        count, parts, [](const void* all, int first, int last) { (*static_cast<const Body*>(all))(first, last); },
        &body);
  else if (count > 0)
    body(0, count);
}

}  // namespace finegauge
