#pragma once

#include <filesystem>

#include "core/scene/scene.hpp"
#include "core/scene/section_reader.hpp"

namespace finegauge {

/// Reads [organ]: the surface from its file, checked and immersed in its lattice. What was mended in the surface is
/// noted in the scene. `folder`: where relative paths start.
void read_organ(const SectionReader& reader, const std::filesystem::path& folder, Scene& scene);

}  // namespace finegauge
