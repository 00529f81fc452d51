#include "benchmarks/program/allocation_counter.hpp"

#include <Eigen/Core>
#include <cstdlib>
#include <memory>
#include <new>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// Keeps the compiler from removing an allocation that nobody looks at.
void keep(void* block) { asm volatile("" : : "r"(block) : "memory"); }

template <class Work>
long allocations_of(Work work) {
  const auto before = heap_allocations();
  work();
  return static_cast<long>(*heap_allocations() - *before);
}

struct alignas(128) Wide {
  double values[16];
};

}  // namespace

TEST_CASE("heap blocks are counted one by one, whoever asks for them", "[allocations]") {
  if (!heap_allocations()) return;  // a sanitizer's allocator, or another C library: the run says null
  CHECK(allocations_of([] {}) == 0);
  CHECK(allocations_of([] {
          for (int i = 0; i < 10; ++i) {
            void* block = std::malloc(100);
            keep(block);
            std::free(block);
          }
        }) == 10);
  CHECK(allocations_of([] { keep(std::make_unique<double>(1.0).get()); }) == 1);
  CHECK(allocations_of([] { keep(std::make_unique<Wide>().get()); }) == 1);  // aligned operator new
  CHECK(allocations_of([] {
          Eigen::VectorXd x = Eigen::VectorXd::Zero(1000);
          keep(x.data());
        }) == 1);
  CHECK(allocations_of([] {
          void* block = nullptr;
          if (posix_memalign(&block, 64, 256) == 0) keep(block);
          block = std::realloc(block, 4096);
          keep(block);
          std::free(block);
        }) == 2);
  CHECK(allocations_of([] {
          Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
          keep(m.data());
        }) == 0);
}
