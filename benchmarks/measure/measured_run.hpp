#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/measure/run_curves.hpp"
#include "benchmarks/measure/strain_samples.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// The solution at one time of a run.
struct StrainInstant {
  double time = 0.0;  ///< [s]; zero for a static scene
  StrainSamples strains;
};

/// A run that others are compared with.
struct ReferenceRun {
  RunCurves curves;
  std::vector<StrainInstant> instants;  ///< ascending in time
  /// Whether its strains are measured in a frame that turns: the norm of all that is compared with it, whatever the
  /// compared runs leave out.
  Kinematics kinematics = Kinematics::linear;
};
/// Bytes for a file (CBOR), and back; throws nlohmann's exceptions and std::runtime_error on other bytes.
std::vector<std::uint8_t> to_bytes(const ReferenceRun& reference);
ReferenceRun reference_run(const std::vector<std::uint8_t>& bytes);

/// One way to run a scene: how long frames take and how far the result is off. All that is told can go through a pipe.
struct MeasuredRun {
  bool complete = false;       ///< to the scene's end, every frame converged
  std::string why_incomplete;  ///< one line; empty when complete
  RunCurves curves;
  /// Processor times of frames (processor_ms), a list for each pass over the scene; a static scene's frame is its whole
  /// adaptive loop. Of one thread that is the wall time of a processor of one's own, whatever else this machine is busy
  /// with; of several it is while none of their processors is anybody else's.
  std::vector<std::vector<double>> frame_ms;
  int frames = 0, unconverged = 0, refined = 0, coarsened = 0;
  int dofs_start = 0, dofs_max = 0, dofs_end = 0;
  double dofs_mean = 0.0;                ///< over frames
  std::int64_t iterations = 0;           ///< of linear solvers and Uzawa's, over one pass
  double work = 0.0;                     ///< Σ dofs × (1 + iterations) over frames: an exact stand-in for time
  std::optional<double> eta_max;         ///< largest estimate of the relative error; none where nothing was estimated
  double peak_memory_mb = 0.0;           ///< of the process
  std::map<std::string, double> errors;  ///< relative, against the reference: `energy_norm` and by quantity
  double reference_size = 0.0;           ///< square of the reference's energy norm, over what was compared [J]
  double left_out = 0.0;  ///< share of the volume that energy_norm could not compare, largest of the instants
};
Json to_json(const MeasuredRun& run);
MeasuredRun measured_run(const Json& json);

struct MeasureOptions {
  int passes_least = 1, passes_most = 1;  ///< over the whole scene, each from rest
  double seconds = 0.0;                   ///< further passes start only while the frames so far took less
  const ReferenceRun* reference = nullptr;
  /// Asked after each frame with the share of the pass that is done; false: stop, incomplete.
  std::function<bool(double)> go_on = [](double) { return true; };
};

/// Runs the scene. Only frames are timed: sampling and comparing happen between them. Never throws for what a scene
/// does while it runs: that is an incomplete run. Throws SceneError for scenes that cannot start.
///
/// The energy norm's error is that of all instants together: √(Σ difference / Σ size), each at the end of the run's
/// frame nearest to the instant's time.
MeasuredRun measure_run(const Scene& scene, const MeasureOptions& options);

/// √(difference / size) of squares of norms; 0 of two bodies at rest, NaN of one that is off from one at rest.
double relative_distance(double difference, double size);

/// Throws SceneError for a scene that cannot start, which reading it does not show: a needle starts in the body,
/// nothing holds it. Takes as long as a static scene's first solve.
void require_start(const Scene& scene);

/// Runs the scene and records it, with its strains at the ends of the frames nearest to `times`; a static scene has one
/// instant whatever is asked. None, with the reason in `why`, for a run that is incomplete.
std::optional<ReferenceRun> record_reference(
    const Scene& scene, const std::vector<double>& times, std::string& why,
    const std::function<bool(double)>& go_on = [](double) { return true; });

/// `count` times, equally spaced to the end of the duration but for rounding to whole `step`s, so that runs whose time
/// steps divide `step` have frames that end there; the end alone where the duration is shorter than `step`. Zero alone
/// for a static scene.
std::vector<double> instants_of(const Scene& scene, double step, int count);

}  // namespace finegauge
