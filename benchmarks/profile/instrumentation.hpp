#pragma once

#include "benchmarks/program/result_document.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// What it costs a moving scene that its stages are timed and recorded.
struct Instrumentation {
  double readings_per_frame = 0.0;  ///< mean
  double reading_ns = 0.0;          ///< one reading with its record: clock, count of allocations, both kept
  double clock_ns = 0.0;            ///< the clock alone, as frames outside of a profile read it
  double frame_ms_off = 0.0, frame_ms_on = 0.0;  ///< medians of the same frames, in turns
  double paired = 0.0;                           ///< median over the frames of on / off - 1
  double paired_low = 0.0, paired_high = 0.0;    ///< 95 % interval of that median (sign test)
  double stage_ms_when_off = 0.0;                ///< sum of all stages' times of all frames without a clock: zero
  bool same_states = false;                      ///< to the bit, with and without
  int frames = 0;

  /// Readings × cost of one over the median frame: what a measurement of frames cannot resolve, computed.
  double share() const { return frame_ms_off > 0.0 ? 1e-6 * readings_per_frame * reading_ns / frame_ms_off : 0.0; }
};

/// The scene twice side by side, frame by frame in turns, recorded and without a stage clock, up to `frames`.
/// Precondition: scene.dynamics.
Instrumentation measure_instrumentation(const Scene& scene, int frames);
Json to_json(const Instrumentation& instrumentation);

}  // namespace finegauge
