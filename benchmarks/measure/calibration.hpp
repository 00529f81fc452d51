#pragma once

#include <cstddef>
#include <vector>

namespace finegauge {

// Kernels of known work, to measure in a run what one core of this machine can do in it: the scale that a stage's bytes
// and flops are compared with, and a yardstick for times on a machine whose speed changes from minute to minute.

/// a <- b + s c over three arrays (the triad of McCalpin's STREAM, 1995). Bytes are counted as there, 24 per element:
/// what a processor fetches of a before it writes it is not counted.
class Triad {
 public:
  /// elements >= 1 per array
  explicit Triad(std::size_t elements);
  /// One pass, in milliseconds. The scalar differs from pass to pass, so that none can be left out.
  double pass_ms();
  double bytes() const { return 24.0 * static_cast<double>(a_.size()); }
  /// Whether every element of a is what the last pass should have left. True before the first.
  bool holds() const;

 private:
  std::vector<double> a_, b_, c_;
  double s_ = 0.0;
};
/// Elements per array for which each array is four times as large as the last cache (STREAM's rule), within 16 and
/// 128 MiB; 32 MiB where the system does not tell the cache's size.
std::size_t triad_elements_beyond_caches();

/// x <- x m + a on many independent x in registers, multiply and add fused (one instruction, as BLAS does it) or apart
/// (as this project's sources are compiled, so that results do not depend on the processor).
enum class MultiplyAdd { fused, separate };
/// Whether this build has an instruction for MultiplyAdd::fused. Without one the two are the same.
bool has_fused_multiply_add();
struct MultiplyAddPass {
  double ms = 0.0;
  double flops = 0.0;  ///< two for each x and step
  double sum = 0.0;    ///< of all x at the end: each tends to a / (1 - m) = 2, wherever it started
};
/// steps >= 1
MultiplyAddPass multiply_add_pass(MultiplyAdd kind, int steps);

/// The medians of passes that take turns, and the best: what the machine can do when nothing disturbs it.
struct MachineRates {
  double bytes_per_second = 0.0;           ///< triad beyond the caches, best
  double fused_flops_per_second = 0.0;     ///< best
  double separate_flops_per_second = 0.0;  ///< best
  double median_over_best = 1.0;  ///< the largest over the three kernels of median over best time: the noise, >= 1
  int passes = 0;
};
/// passes >= 1; about 40 ms each on a machine of 20 GB/s.
MachineRates measure_machine(int passes = 9);

}  // namespace finegauge
