#pragma once

#include <string>
#include <vector>

#include "core/scene/scene_error.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/temporary_file.hpp"

namespace finegauge {

using Strings = std::vector<std::string>;

/// Scenes as text, changed in one place and read from a temporary file.

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

inline Scene read(const std::string& text, const Strings& overrides = {}) {
  const TemporaryFile file("scene.toml", text);
  return read_scene(file.path(), overrides);
}

/// The message, from the line number on when it names the file; "accepted" without one.
inline std::string refusal(const std::string& text, const Strings& overrides = {}) {
  const TemporaryFile file("scene.toml", text);
  try {
    (void)read_scene(file.path(), overrides);
  } catch (const SceneError& error) {
    const std::string message = error.what(), name = file.path().string() + ":";
    return message.rfind(name, 0) == 0 ? message.substr(name.size()) : message;
  }
  return "accepted";
}

inline void check_begins(const std::string& found, const std::string& expected) {
  CHECK(found.substr(0, expected.size()) == expected);
}

}  // namespace finegauge
