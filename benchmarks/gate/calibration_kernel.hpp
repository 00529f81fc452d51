#pragma once

#include <cstdint>
#include <memory>

namespace finegauge {

/// Of a miniature frame [ms].
struct KernelTime {
  double wall_ms = 0.0, processor_ms = 0.0;
};

/// The yardstick of frame times on a machine and at a moment: a miniature frame of fixed work, written apart from the
/// core so that nothing that makes the core slower makes it slower too. Its mix is that of a frame with a needle in
/// some 1,800 degrees of freedom: 3 × 3 block matrix-vector products of a conjugate gradients solve (a megabyte, L2),
/// rotated cell stiffnesses of 24 × 24 (L1), passes over 4 MiB as of a kept factor (L3), and a sort of the cells by
/// error. About a millisecond. Not more than a yardstick: on a processor with another balance of caches a frame's
/// ratio to it shifts by tens of percent.
class CalibrationKernel {
 public:
  CalibrationKernel();
  ~CalibrationKernel();
  CalibrationKernel(const CalibrationKernel&) = delete;
  CalibrationKernel& operator=(const CalibrationKernel&) = delete;

  /// Does one miniature frame; the same number each time, to the last bit.
  double frame();
  /// Median times of a miniature frame now, over `frames` of them after a tenth as many to warm up. Throws
  /// std::runtime_error when one of them has another result than the first had.
  KernelTime measure(int frames);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
  double expected_ = 0.0;
};

}  // namespace finegauge
