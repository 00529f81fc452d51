#pragma once

#include <cstdint>
#include <optional>

namespace finegauge {

/// Heap blocks that this process asked for so far, by whatever library (operator new, Eigen, BLAS, CHOLMOD): calls of
/// malloc, calloc, realloc and the aligned ones. None where they cannot be counted exactly: without the GNU C library,
/// or under a sanitizer, which has an allocator of its own.
std::optional<std::int64_t> heap_allocations();

}  // namespace finegauge
