#pragma once

#include <filesystem>
#include <vector>

namespace finegauge {

/// The scene files that come with the program, if this machine has them; sorted.
std::vector<std::filesystem::path> known_scenes();

}  // namespace finegauge
