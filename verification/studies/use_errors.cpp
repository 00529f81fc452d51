#include "verification/studies/use_errors.hpp"

#include <stdexcept>

#include "core/scene/scene_error.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/support/temporary_file.hpp"

namespace finegauge {

namespace {

Refusal read_text(const std::string& text, const SceneMistake& mistake) {
  const TemporaryFile file("use_error.toml", text);
  Refusal refusal;
  try {
    (void)read_scene(file.path(), {});
    return refusal;
  } catch (const SceneError& error) {
    refusal.message = error.what();
  }
  refusal.refused = true;
  const std::string name = file.path().string() + ":";
  refusal.names_file = refusal.message.starts_with(name);
  refusal.names_line =
      refusal.names_file &&
      (mistake.line == 0 || refusal.message.substr(name.size()).starts_with(std::to_string(mistake.line) + ":"));
  refusal.names_field = refusal.message.find(mistake.field) != std::string::npos;
  return refusal;
}

}  // namespace

std::string sound_scene() {
  return R"(name = "sound"

[box]
size = [0.4, 0.1, 0.1]
cells = [8, 2, 2]

[material]
youngs_modulus = 1e6
poisson_ratio = 0.3
dilatation = "mean"
kinematics = "linear"

[[support]]
surface = "x_min"

[[load]]
surface = "x_max"
traction = [0, 0, -10]

[adapt]
steps = 2
theta = 0.3
)";
}

std::vector<SceneMistake> scene_mistakes() {
  return {{"negative stiffness", "youngs_modulus = 1e6", "youngs_modulus = -1e6", "youngs_modulus", 8},
          {"stiffness that is no number", "youngs_modulus = 1e6", "youngs_modulus = nan", "youngs_modulus", 8},
          {"stiffness as text", "youngs_modulus = 1e6", "youngs_modulus = \"1e6\"", "youngs_modulus", 8},
          {"Poisson ratio of one half", "poisson_ratio = 0.3", "poisson_ratio = 0.5", "poisson_ratio", 9},
          {"misspelt key", "poisson_ratio = 0.3", "poisson_ration = 0.3", "poisson_ration", 9},
          {"choice that is none", "dilatation = \"mean\"", "dilatation = \"average\"", "dilatation", 10},
          {"no cells", "cells = [8, 2, 2]", "cells = [8, 0, 2]", "cells", 5},
          {"two coordinates for three", "size = [0.4, 0.1, 0.1]", "size = [0.4, 0.1]", "size", 4},
          {"flat body", "size = [0.4, 0.1, 0.1]", "size = [0.4, 0.0, 0.1]", "size", 4},
          {"surface that does not exist", "surface = \"x_max\"", "surface = \"xmax\"", "surface", 17},
          {"infinite load", "traction = [0, 0, -10]", "traction = [0, 0, -inf]", "traction", 18},
          {"load twice, in two ways", "traction = [0, 0, -10]", "traction = [0, 0, -10]\ntotal_force = [0, 0, -1]",
           "total_force", 18},
          {"share above one", "theta = 0.3", "theta = 1.5", "theta", 22},
          {"part of a step", "steps = 2", "steps = 2.5", "steps", 21},
          {"key of a moving scene", "theta = 0.3", "theta = 0.3\ndwell = 5", "dwell", 23},
          {"section that does not exist", "[adapt]", "[adaptivity]", "adaptivity", 20},
          {"missing stiffness", "youngs_modulus = 1e6\n", "", "youngs_modulus", 0},
          {"text that is no TOML", "[material]", "[material", "", 7}};
}

Refusal read_with(const SceneMistake& mistake) {
  std::string text = sound_scene();
  const std::size_t at = text.find(mistake.from);
  if (at == std::string::npos) throw std::logic_error("use_errors: the sound scene has no \"" + mistake.from + "\"");
  return read_text(text.replace(at, mistake.from.size(), mistake.to), mistake);
}

Evidence use_errors_evidence(const EvidenceOptions&) {
  Evidence evidence;
  EvidenceTable table{
      "What the reader says to mistakes in a scene", {"mistake", "message, from the line number on"}, {}};
  double mistakes = 0.0, refused = 0.0, placed = 0.0, named = 0.0;
  for (const SceneMistake& mistake : scene_mistakes()) {
    const Refusal refusal = read_with(mistake);
    mistakes += 1.0, refused += refusal.refused, placed += refusal.names_line, named += refusal.names_field;
    const std::size_t after_file = refusal.message.find(".toml:");
    table.rows.push_back({mistake.name, refusal.refused ? refusal.message.substr(after_file + 6) : "accepted"});
  }
  const bool sound = !read_text(sound_scene(), {}).refused;
  evidence.tables.push_back(std::move(table));
  evidence.claim("sound_scene_is_read", sound, 1.0, 1.0, "a reader that refuses everything would pass all else");
  evidence.claim("mistakes_refused", refused / mistakes, 1.0, 1.0, "none is computed with");
  evidence.claim("file_and_line_named", placed / mistakes, 1.0, 1.0, "so that a user finds the place");
  evidence.claim("field_named", named / mistakes, 1.0, 1.0, "so that a user knows what is wrong there");
  return evidence;
}

}  // namespace finegauge
