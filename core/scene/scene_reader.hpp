#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/scene/scene.hpp"
#include "core/scene/scene_error.hpp"

namespace finegauge {

/// Reads and checks a scene: every key by the table of scene_keys.hpp, then what keys must agree on, up to surfaces
/// that exist and cells that are not inverted. Whether the body is held is known only with a discretization:
/// check_held.hpp. `overrides` are the arguments of `--set`, "KEY=VALUE", applied in order before any check.
/// Throws SceneError.
Scene read_scene(const std::filesystem::path& file, std::span<const std::string> overrides = {});

}  // namespace finegauge
