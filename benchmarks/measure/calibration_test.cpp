#include "benchmarks/measure/calibration.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <vector>

#include "verification/support/catch.hpp"

using namespace finegauge;
using Catch::Matchers::WithinAbs;

TEST_CASE("calibration kernels do the work that they count", "[calibration]") {
  Triad triad(1001);
  CHECK(triad.bytes() == 24.0 * 1001);
  for (int pass = 0; pass < 3; ++pass) {
    CHECK(triad.pass_ms() > 0.0);
    CHECK(triad.holds());
  }
  for (const MultiplyAdd kind : {MultiplyAdd::fused, MultiplyAdd::separate}) {
    // x - 2 shrinks by 3/4 a step. At the end each x is 2, so their sum counts them: one flop of each for every step
    // and unit of the sum.
    const MultiplyAddPass one = multiply_add_pass(kind, 1), many = multiply_add_pass(kind, 1000);
    CHECK_THAT(many.flops / (1000.0 * many.sum), WithinAbs(1.0, 1e-12));
    const double start = (one.sum - many.sum) / 0.75;  // Σ x - 2 before the first step
    CHECK(start > 0.1 * many.sum);
    CHECK_THAT(multiply_add_pass(kind, 10).sum / (many.sum + std::pow(0.75, 10) * start), WithinAbs(1.0, 1e-12));
    CHECK(multiply_add_pass(kind, 10).flops == 10.0 * multiply_add_pass(kind, 1).flops);
  }
}

TEST_CASE("a calibration kernel's time grows with its work", "[calibration]") {
  // The best of several, since other processes disturb: eight times the work takes between 4 and 16 times as long.
  const auto best = [](int repetitions, const auto& pass) {
    double least = INFINITY;
    for (int i = 0; i < repetitions; ++i) least = std::min(least, pass());
    return least;
  };
  for (const MultiplyAdd kind : {MultiplyAdd::fused, MultiplyAdd::separate}) {
    const double one = best(15, [&] { return multiply_add_pass(kind, 20000).ms; });
    const double eight = best(15, [&] { return multiply_add_pass(kind, 160000).ms; });
    CAPTURE(one, eight);
    CHECK(eight > 4.0 * one);
    CHECK(eight < 16.0 * one);
  }
}

TEST_CASE("the machine's rates are those of the machine", "[calibration]") {
  const MachineRates rates = measure_machine(3);
  CAPTURE(rates.bytes_per_second, rates.fused_flops_per_second, rates.separate_flops_per_second);
  CHECK(rates.passes == 3);
  CHECK(rates.median_over_best >= 1.0);
  // The C library's copy of the same memory is the independent measure: two streams in place of three. A kernel that
  // was optimized away, or a wrong count of bytes by a power of ten, is out of these bounds.
  const std::size_t n = triad_elements_beyond_caches();
  std::vector<double> from(n, 1.0), to(n, 0.0);
  double best_ms = INFINITY;
  for (int i = 0; i < 4; ++i) {
    from[0] = i;
    const auto start = std::chrono::steady_clock::now();
    std::memcpy(to.data(), from.data(), n * sizeof(double));
    best_ms =
        std::min(best_ms, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    REQUIRE(to[0] == i);
  }
  const double copied = 1e3 * 16.0 * static_cast<double>(n) / best_ms;
  CAPTURE(copied);
  CHECK(rates.bytes_per_second > 0.2 * copied);
  CHECK(rates.bytes_per_second < 5.0 * copied);
  // Two instructions in place of one: at most twice as slow where each takes a turn of the same unit, equal where a
  // processor has units for both or no fused instruction.
  const double ratio = rates.fused_flops_per_second / rates.separate_flops_per_second;
  CHECK(ratio > 0.6);
  CHECK(ratio < 3.5);
  // Between a chain of dependent scalars at 1 GHz and 64 flops a cycle at 10 GHz.
  CHECK(rates.fused_flops_per_second > 2.5e8);
  CHECK(rates.fused_flops_per_second < 6.4e11);
}
