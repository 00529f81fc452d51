#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// A scene and a changed one, side by side.
struct SceneComparison {
  /// Both to the end. Frames of moving scenes that did not converge are counted, and count as complete; a static scene
  /// that did not is no solution.
  bool complete = false;
  std::string why_incomplete;
  std::map<std::string, double> quantity_change;  ///< relative to the first, by quantity (errors_against); NaN: nothing
                                                  ///< to compare
  /// Of the strains of all instants, relative; 0 between two bodies at rest. NaN until both are complete, like times.
  double energy_norm_change = std::numeric_limits<double>::quiet_NaN();
  double mean_ms = energy_norm_change, changed_mean_ms = energy_norm_change;  ///< of a frame, processor time
  double p99_ms = energy_norm_change, changed_p99_ms = energy_norm_change;
  int unconverged = 0, changed_unconverged = 0;

  double time_change() const { return changed_mean_ms / mean_ms - 1.0; }
  /// The largest of the quantities' changes or, where the scene has none that can be compared, that of the energy norm.
  double largest_change() const;
};
Json to_json(const SceneComparison& comparison);
SceneComparison scene_comparison(const Json& json);

/// Runs both, a frame of each in turn and the order of each turn drawn by lot, so that what disturbs the machine
/// disturbs both alike. Static scenes are solved so several times over. Throws SceneError for scenes that cannot start.
SceneComparison compare_scenes(const Scene& scene, const Scene& changed, std::uint64_t seed);

}  // namespace finegauge
