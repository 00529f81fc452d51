#pragma once

#include <string>
#include <vector>

#include "verification/support/evidence.hpp"

namespace finegauge {

/// A mistake in a scene, and what a user has to be told of it.
struct SceneMistake {
  std::string name;
  std::string from, to;  ///< the replacement in the sound scene that makes it
  std::string field;     ///< that the message has to name
  int line;              ///< and its line; 0: the field is missing, so any
};
/// What the reader said.
struct Refusal {
  bool refused = false, names_file = false, names_line = false, names_field = false;
  std::string message;
};

/// A sound static scene, and mistakes in it: values out of range, of the wrong kind or no numbers, misspelt keys and
/// sections, keys that contradict each other, surfaces that do not exist.
std::string sound_scene();
std::vector<SceneMistake> scene_mistakes();
Refusal read_with(const SceneMistake& mistake);

Evidence use_errors_evidence(const EvidenceOptions& options);

}  // namespace finegauge
