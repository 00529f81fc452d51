#include <sstream>

#include "core/scene/scene_keys.hpp"

namespace finegauge {
namespace {

constexpr std::string_view introduction =
    R"(A scene is a TOML file (https://toml.io) of at most 16 MiB. Each key below: type and range [unit], default,
explanation. Unknown keys and sections are errors. Lists count from 0. Numbers are zero or of a magnitude of
1e-60 to 1e60. Units are SI as they stand; a consistent system of others works as well (mm, g, s).
A scene with [dynamics] moves, without it is static. The example at the end is static;
reference_data/scenes/phantom.toml has a needle.

--set KEY=VALUE replaces or adds a key before anything is checked and may be repeated. KEY is a dotted path such as
material.poisson_ratio, or load[0].traction for the first of several sections; VALUE is a TOML value (a text may go
without its quotes): --set box.cells=[16,16,8] --set solver.method=direct
)";

constexpr std::string_view example = R"(name = "cantilever"
description = "A beam held at one end, pulled down at the other, refined where the error is."
units = "SI"

[box]
size = [0.4, 0.1, 0.1]         # m
cells = [8, 2, 2]
shape = "hexahedron"

[[surface]]
name = "tip"
normal = [1, 0, 0]
point = [0.4, 0, 0]

[material]
youngs_modulus = 1e4           # Pa
poisson_ratio = 0.4
dilatation = "mean"
kinematics = "corotational"

[[support]]
surface = "x_min"              # clamped

[[support]]
surface = "y_min"              # a sliding plane of symmetry
components = ["y"]

[[load]]
surface = "tip"
total_force = [0, 0, -0.2]     # N
share = "area"

[[load]]
body_force = [0, 0, -10.0]     # N/m^3

[[refine]]
min = [0, 0, 0]
max = [0.1, 0.1, 0.1]
template = "2x2x2"
levels = 1

[adapt]
steps = 3
marking = "bulk"
theta = 0.5
policy = "directional"
tolerance = 0.05
max_dofs = 20000

[solver]
method = "automatic"
relative_residual = 1e-8

[[quantity]]
kind = "energy"

[[quantity]]
name = "tip_displacement"
kind = "displacement"
point = [0.4, 0.05, 0.05]
)";

/// Appends words broken at spaces to lines of at most `width` characters.
void append_wrapped(std::ostringstream& out, const std::string& words, const std::string& indent) {
  constexpr std::size_t width = 110;
  std::istringstream in(words);
  std::string word, line = indent;
  while (in >> word) {
    if (line.size() > indent.size() && line.size() + 1 + word.size() > width) {
      out << line << '\n';
      line = indent;
    }
    line += (line.size() > indent.size() ? " " : "") + word;
  }
  out << line << '\n';
}

}  // namespace

std::string_view example_scene() { return example; }

std::string scene_help() {
  std::ostringstream out;
  out << introduction;
  for (const SceneSection& section : scene_sections()) {
    out << '\n';
    const std::string name(section.name);
    if (name.empty())
      out << "(top)";
    else
      out << (section.repeated ? "[[" + name + "]]" : "[" + name + "]");
    out << (section.repeated ? "  any number of times" : section.required ? "  required" : "  optional") << '\n';
    append_wrapped(out, std::string(section.explanation), "  ");
    for (const SceneKey& key : scene_keys()) {
      if (key.section != section.name) continue;
      std::string words = std::string(key.key) + ": " + allowed_values(key);
      if (!key.unit.empty()) words += " [" + std::string(key.unit) + "]";
      words += key.default_value == required_key ? "; required" : "; default " + std::string(key.default_value);
      if (!key.moving_default.empty()) words += ", " + std::string(key.moving_default) + " in a moving scene";
      if (key.scope != KeyScope::always)
        words += key.scope == KeyScope::moving_only ? "; moving scenes only" : "; static scenes only";
      append_wrapped(out, words, "    ");
      append_wrapped(out, std::string(key.explanation), "        ");
    }
  }
  out << "\nExample\n\n" << example;
  return out.str();
}

}  // namespace finegauge
