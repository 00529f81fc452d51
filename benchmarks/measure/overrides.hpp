#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace finegauge {

/// The command that runs a scene with --set arguments, the lists one after the other, quoted for a shell where needed.
std::string run_command(const std::string& scene, const std::vector<std::string>& first,
                        const std::vector<std::string>& then);

/// What --quick adds for a moving scene: a tenth of its duration, eight frames at least, never more than it has.
std::vector<std::string> quick_overrides(const Scene& scene);

}  // namespace finegauge
