#pragma once

#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"
#include "core/scene/scene.hpp"

namespace finegauge {

/// A value that a user can choose, as arguments of --set; none where it is the scene's own.
struct TradeChoice {
  std::string label;  ///< "9 x 4 x 4", "off"
  std::vector<std::string> overrides;
  int threads = 0;  ///< of the run; zero: those of the sweep
};

/// What a user can choose in a scene, one thing, its values in order from cheap to dear as far as they have one.
struct TradeAxis {
  std::string name;
  std::string about;  ///< one line
  std::vector<TradeChoice> choices;
  int own = 0;  ///< the scene's own
};

Json to_json(const TradeAxis& axis);
TradeAxis trade_axis(const Json& json);

/// The axes that a scene has: without a needle there is none of its elements. What would change the problem instead of
/// how it is solved (moduli, strokes, friction, and cut_advance, which is the length of a cut as well as the spacing of
/// the shaft's points) is no axis. Threads are one where there are several of the `processors` of this machine that a
/// run may use; `threads` is the sweep's own number of them.
std::vector<TradeAxis> trade_axes(const Scene& scene, int threads, int processors);

/// A choice on each axis.
using TradeSetting = std::vector<int>;
TradeSetting own_setting(const std::vector<TradeAxis>& axes);
/// Arguments of --set, in the order of the axes.
std::vector<std::string> overrides(const std::vector<TradeAxis>& axes, const TradeSetting& setting);
/// Zero where the setting chooses none.
int threads(const std::vector<TradeAxis>& axes, const TradeSetting& setting);
/// What sets apart a setting from the scene's own: "base_mesh 18 x 8 x 8, adaptivity off"; "as the scene has it".
std::string describe(const std::vector<TradeAxis>& axes, const TradeSetting& setting);

/// A run so fine that the errors of the others can be measured by it, and a coarser one of the same kind, whose
/// distance from it says how far it may itself be off.
struct TradeReference {
  std::vector<std::string> fine, coarser;  ///< arguments of --set
};
TradeReference trade_reference(const Scene& scene);

/// The longest time step of the axes [s]; zero for a static scene.
double longest_time_step(const Scene& scene);

}  // namespace finegauge
