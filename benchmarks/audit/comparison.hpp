#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// A scene and a changed one, side by side.
struct SceneComparison {
  bool complete = false;  ///< both to the end; frames that did not converge are counted, and count as complete
  std::string why_incomplete;
  std::map<std::string, double> quantity_change;  ///< relative to the first, by quantity (errors_against); NaN: nothing
                                                  ///< to compare
  double energy_norm_change = 0.0;                ///< of the strains of all instants, relative
  double mean_ms = 0.0, changed_mean_ms = 0.0;    ///< of a frame, processor time
  double p99_ms = 0.0, changed_p99_ms = 0.0;
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
