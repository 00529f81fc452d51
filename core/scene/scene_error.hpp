#pragma once

#include <stdexcept>
#include <string>

namespace finegauge {

/// Bad input from a scene file, a mesh file or `--set`. `what()` is the one message for the user:
/// "FILE:LINE: field: what was found, what is allowed".
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(const std::string& message) : std::runtime_error(message) {}
};

}  // namespace finegauge
