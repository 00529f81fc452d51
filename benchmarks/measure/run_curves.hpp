#pragma once

#include <map>
#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// What a run leaves of itself to be compared, frame by frame. A static run is one frame at time zero.
struct RunCurves {
  std::vector<double> time;                           ///< [s]
  std::vector<double> travel, force, tip_force;       ///< of a needle, else empty: [m], [N], [N]
  std::map<std::string, std::vector<double>> values;  ///< by quantity: displacements x, y, z of each frame, energies

  void add(double frame_time, const Json& quantities);  ///< of MotionFrame or StaticStep
};
Json to_json(const RunCurves& curves);
/// Throws nlohmann's exceptions on what to_json did not make.
RunCurves run_curves(const Json& json);

/// How far each of the scene's quantities is off, relative, by name; NaN where there is nothing to compare.
///
/// - displacement, energy: root mean square over the times of `curves` of the difference, over that of the reference
///   (interpolated between its frames; frames after its last are left out)
/// - force_curve: the same of the whole force over the travel of the tip, on the way in (force_curves.hpp)
/// - tip_force: the difference of the tip's work over the travel that both cover on the way in, over the reference's
///   work. The force itself jumps at every cut, and its phase would hide its size.
std::map<std::string, double> errors_against(const RunCurves& reference, const RunCurves& curves,
                                             const std::vector<QuantityOfInterest>& quantities);

}  // namespace finegauge
