#include "benchmarks/measure/calibration.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace finegauge {
namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

constexpr double b_value = 1.0, c_value = 0.5;

// x m + a has the fixed point 2.
constexpr double factor = 0.75, addend = 0.5;

/// Hides a value from the optimizer, which might otherwise know a kernel's result.
template <class Value>
void hide(Value& value) {
  asm volatile("" : "+m"(value) : : "memory");
}

// A register of the widest kind that has a fused instruction, and so that both kinds of pass use the same width.
#if defined(__AVX512F__)
using Register = __m512d;
Register fused(const Register& x, const Register& m, const Register& a) { return _mm512_fmadd_pd(x, m, a); }
constexpr bool fuses = true;
#elif defined(__FMA__)
using Register = __m256d;
Register fused(const Register& x, const Register& m, const Register& a) { return _mm256_fmadd_pd(x, m, a); }
constexpr bool fuses = true;
#else
typedef double Register __attribute__((vector_size(16)));
Register fused(const Register& x, const Register& m, const Register& a) { return x * m + a; }
constexpr bool fuses = false;
#endif
constexpr int lanes = sizeof(Register) / sizeof(double);
// Independent chains: latency (4 cycles) times throughput (2 a cycle) of today's processors, and some more; with the
// two constants they fit 16 registers.
constexpr int chains = 12;

/// Not std::array, which would drop the alignment of a register's type.
struct Chains {
  Register x[chains];
};

Register all(double value) {
  std::array<double, lanes> values;
  values.fill(value);
  Register result;
  std::memcpy(&result, values.data(), sizeof result);
  return result;
}

template <class Step>
double run_chains(int steps, Chains& values, const Step& step) {
  Register m = all(factor), a = all(addend);
  hide(m);
  hide(a);
  hide(values);
  const auto start = std::chrono::steady_clock::now();
  // Twelve locals and no array: an array's elements might live in memory.
  Register* const x = values.x;
  Register x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3], x4 = x[4], x5 = x[5], x6 = x[6], x7 = x[7], x8 = x[8], x9 = x[9],
           x10 = x[10], x11 = x[11];
  for (int i = 0; i < steps; ++i) {
    x0 = step(x0, m, a), x1 = step(x1, m, a), x2 = step(x2, m, a), x3 = step(x3, m, a);
    x4 = step(x4, m, a), x5 = step(x5, m, a), x6 = step(x6, m, a), x7 = step(x7, m, a);
    x8 = step(x8, m, a), x9 = step(x9, m, a), x10 = step(x10, m, a), x11 = step(x11, m, a);
  }
  values = {{x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11}};
  hide(values);
  return milliseconds_since(start);
}

struct BestAndMedian {
  double best, median;
};
BestAndMedian best_and_median(std::vector<double> times) {
  std::sort(times.begin(), times.end());
  return {times.front(), times[times.size() / 2]};
}

}  // namespace

Triad::Triad(std::size_t elements) : a_(elements, b_value), b_(elements, b_value), c_(elements, c_value) {}

double Triad::pass_ms() {
  s_ += 1.0;
  const auto start = std::chrono::steady_clock::now();
  double* const a = a_.data();
  const double *const b = b_.data(), *const c = c_.data();
  const std::size_t n = a_.size();
  for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + s_ * c[i];
  hide(*a);
  return milliseconds_since(start);
}

bool Triad::holds() const {
  return std::all_of(a_.begin(), a_.end(), [&](double a) { return a == b_value + s_ * c_value; });
}

std::size_t triad_elements_beyond_caches() {
  constexpr long mebibyte = 1 << 20;
  long cache = 0;
#ifdef _SC_LEVEL3_CACHE_SIZE
  cache = std::max(::sysconf(_SC_LEVEL3_CACHE_SIZE), ::sysconf(_SC_LEVEL2_CACHE_SIZE));
#endif
  const long bytes = cache > 0 ? std::clamp(4 * cache, 16 * mebibyte, 128 * mebibyte) : 32 * mebibyte;
  return static_cast<std::size_t>(bytes) / sizeof(double);
}

bool has_fused_multiply_add() { return fuses; }

MultiplyAddPass multiply_add_pass(MultiplyAdd kind, int steps) {
  Chains x;
  for (int k = 0; k < chains; ++k) x.x[k] = all(k);
  MultiplyAddPass pass;
  pass.flops = 2.0 * lanes * chains * steps;
  pass.ms =
      kind == MultiplyAdd::fused
          ? run_chains(steps, x, [](const Register& y, const Register& m, const Register& a) { return fused(y, m, a); })
          : run_chains(steps, x, [](const Register& y, const Register& m, const Register& a) { return y * m + a; });
  std::array<double, lanes * chains> values;
  std::memcpy(values.data(), x.x, sizeof values);
  for (const double value : values) pass.sum += value;
  return pass;
}

MachineRates measure_machine(int passes) {
  constexpr int steps = 1000000;
  Triad triad(triad_elements_beyond_caches());
  (void)triad.pass_ms();  // first touch of the pages
  (void)multiply_add_pass(MultiplyAdd::fused, steps);
  std::vector<double> triad_ms, fused_ms, separate_ms;
  double flops = 0.0;
  for (int pass = 0; pass < passes; ++pass) {
    triad_ms.push_back(triad.pass_ms());
    const MultiplyAddPass one = multiply_add_pass(MultiplyAdd::fused, steps);
    fused_ms.push_back(one.ms);
    flops = one.flops;
    separate_ms.push_back(multiply_add_pass(MultiplyAdd::separate, steps).ms);
  }
  const BestAndMedian t = best_and_median(triad_ms), f = best_and_median(fused_ms), s = best_and_median(separate_ms);
  MachineRates rates;
  rates.bytes_per_second = 1e3 * triad.bytes() / t.best;
  rates.fused_flops_per_second = 1e3 * flops / f.best;
  rates.separate_flops_per_second = 1e3 * flops / s.best;
  rates.median_over_best = std::max({t.median / t.best, f.median / f.best, s.median / s.best});
  rates.passes = passes;
  return rates;
}

}  // namespace finegauge
