#include "benchmarks/measure/overrides.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace finegauge {
namespace {

constexpr double quick_share = 0.1, least_quick_frames = 8.0;

std::string quoted(const std::string& text) {
  return text.find_first_of(" []\"'") == std::string::npos ? text : "'" + text + "'";
}

}  // namespace

std::string run_command(const std::string& scene, const std::vector<std::string>& first,
                        const std::vector<std::string>& then) {
  std::string command = "finegauge run " + scene;
  for (const auto& list : {first, then})
    for (const std::string& one : list) command.append(" --set ").append(quoted(one));
  return command;
}

std::vector<std::string> quick_overrides(const Scene& scene) {
  if (!scene.dynamics) return {};
  const double whole = scene.dynamics->duration, frame = scene.dynamics->time_step;
  std::array<char, 64> text;
  std::snprintf(text.data(), text.size(), "dynamics.duration=%.6g",
                std::min(whole, std::max(quick_share * whole, least_quick_frames * frame)));
  return {text.data()};
}

}  // namespace finegauge
