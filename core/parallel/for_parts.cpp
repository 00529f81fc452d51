#include "core/parallel/for_parts.hpp"

#include <cstdint>
#include <exception>
#ifdef _OPENMP
#include <omp.h>
#endif

namespace finegauge {
namespace {

int threads = 1;

}  // namespace

int thread_count() { return threads; }

#ifdef _OPENMP

void set_thread_count(int count) { threads = std::max(1, count); }
int processor_count() { return omp_get_num_procs(); }

void detail::run_parts(int count, int parts, void (*part)(const void* body, int first, int last), const void* body) {
  // None may leave a parallel region. That of the first part is the one that a single thread would have met.
  std::exception_ptr failure;
  std::int64_t failed = parts;
  // A program may have switched off all parallel regions but these (CHOLMOD has some with four threads).
  const int levels = omp_get_max_active_levels();
  if (levels < 1) omp_set_max_active_levels(1);
#pragma omp parallel num_threads(parts)
  {
    // Of as many threads as there came to be, which may be fewer than were asked for.
    const std::int64_t number = omp_get_thread_num(), of = omp_get_num_threads();
    const int first = static_cast<int>(count * number / of), last = static_cast<int>(count * (number + 1) / of);
    try {
      if (first < last) part(body, first, last);
    } catch (...) {
#pragma omp critical(finegauge_failure_of_a_part)
      if (number < failed) failed = number, failure = std::current_exception();
    }
  }
  if (levels < 1) omp_set_max_active_levels(levels);
  if (failure) std::rethrow_exception(failure);
}

#else

void set_thread_count(int) {}
int processor_count() { return 1; }

void detail::run_parts(int count, int, void (*part)(const void* body, int first, int last), const void* body) {
  part(body, 0, count);
}

#endif

}  // namespace finegauge
