#include "benchmarks/program/allocation_counter.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FINEGAUGE_OWN_ALLOCATOR 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define FINEGAUGE_OWN_ALLOCATOR 1
#endif
#endif

#if defined(__GLIBC__) && !defined(FINEGAUGE_OWN_ALLOCATOR)

namespace {

// Constant-initialized: the first calls come before any constructor.
constinit std::atomic<std::int64_t> calls{0};

void count() { calls.fetch_add(1, std::memory_order_relaxed); }

}  // namespace

// The executable's definitions go before those of the C library, for every library in the process ("Replacing malloc"
// in its manual). They pass on to the C library's own allocator by the names that it exports for this; blocks are its
// own, so free stays as it is.
extern "C" {

#ifdef __clang__
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wreserved-identifier"  // the C library's names
#endif
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
#ifdef __clang__
#pragma clang diagnostic pop
#endif

void* malloc(std::size_t size) noexcept {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) noexcept {
  count();
  return __libc_calloc(number, size);
}
void* realloc(void* block, std::size_t size) noexcept {
  count();
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  count();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  if (alignment % sizeof(void*) != 0 || alignment == 0 || (alignment & (alignment - 1)) != 0) return EINVAL;
  count();
  void* made = __libc_memalign(alignment, size);
  if (!made) return ENOMEM;
  *block = made;
  return 0;
}

}  // extern "C"

namespace finegauge {

std::optional<std::int64_t> heap_allocations() { return calls.load(std::memory_order_relaxed); }

}  // namespace finegauge

#else

namespace finegauge {

std::optional<std::int64_t> heap_allocations() { return std::nullopt; }

}  // namespace finegauge

#endif
