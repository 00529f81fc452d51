#include "benchmarks/program/known_scenes.hpp"

#include <algorithm>

namespace finegauge {

std::vector<std::filesystem::path> known_scenes() {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path root : {"reference_data", FINEGAUGE_SOURCE_DIR "/reference_data"}) {
    std::error_code missing;
    for (const auto& entry : std::filesystem::directory_iterator(root / "scenes", missing))
      if (entry.path().extension() == ".toml") files.push_back(entry.path());
    if (!files.empty()) break;
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace finegauge
