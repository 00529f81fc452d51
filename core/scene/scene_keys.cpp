#include "core/scene/scene_keys.hpp"

#include <algorithm>
#include <sstream>
#include <vector>

namespace finegauge {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

constexpr KeyRange any{};
constexpr KeyRange above_zero{.low = 0.0};
constexpr KeyRange whole(double low, double high, std::string_view why = {}) {
  return {.low = low, .high = high, .low_allowed = true, .high_allowed = true, .why = why};
}

constexpr SceneSection sections[] = {
    {"", false, true, "what the scene is; these keys stand before the first section"},
    {"box", false, false, "geometry: a box, or a box without a block of cells; exactly one of [box], [mesh], [gmsh]"},
    {"mesh", false, false, "geometry: nodes and cells listed here"},
    {"gmsh", false, false, "geometry: a mesh file, gmsh 2.2 or 4.1 in ASCII"},
    {"surface", true, false,
     "a named surface beside x_min, x_max, y_min, y_max, z_min, z_max (faces in the planes of the bounding box), "
     "boundary (all), notch (of a removed block) and the physical surfaces of a gmsh file; a plane, or nodes"},
    {"material", false, true, "isotropic elasticity"},
    {"support", true, false, "a surface of known displacement u(X) = displacement + gradient X, X the rest position"},
    {"load", true, false, "exactly one of traction and total_force on a surface, or body_force; several add up"},
    {"refine", true, false, "refinement before the first solve, in the order of the file"},
    {"adapt", false, false, "refinement by estimated error: solve, estimate, mark, refine, again"},
    {"solver", false, false, "how the equilibrium is found"},
    {"quantity", true, false, "a quantity of interest"},
};

constexpr SceneKey keys[] = {
    {"", "name", KeyType::text, "", any, "", optional_key, "short name, used for result files; none: the file's name"},
    {"", "description", KeyType::text, "", any, "", "\"\"", "what the scene shows and where it comes from"},
    {"", "units", KeyType::choice, "", any, "SI|none", "\"SI\"", "none: dimensionless, units below are proportions"},

    {"box", "origin", KeyType::vector, "m", any, "", "[0, 0, 0]", "lower corner"},
    {"box", "size", KeyType::vector, "m", above_zero, "", required_key, "edge lengths"},
    {"box", "cells", KeyType::integers3, "", whole(1, 4096, "and at most 4,000,000 in all"), "", required_key,
     "cells along each axis"},
    {"box", "shape", KeyType::choice, "", any, "hexahedron|tetrahedron", "\"hexahedron\"",
     "shape of the cells; tetrahedra: six in each cell of the lattice"},
    {"box", "removed_first", KeyType::integers3, "", whole(0, 4096), "", optional_key,
     "first lattice cell of a removed block along each axis, from 0"},
    {"box", "removed_last", KeyType::integers3, "", whole(0, 4096), "", optional_key,
     "lattice cell after the last of the removed block along each axis"},

    {"mesh", "shape", KeyType::choice, "", any, "hexahedron|tetrahedron", "\"hexahedron\"", "shape of all cells"},
    {"mesh", "nodes", KeyType::points, "m", any, "", required_key, "rest positions"},
    {"mesh", "cells", KeyType::index_lists, "", whole(0, 2147483647), "", required_key,
     "corners of each cell by node number from 0, in the order of VTK and gmsh"},

    {"gmsh", "file", KeyType::text, "", any, "", required_key,
     "path, relative to the scene file; first-order hexahedra or tetrahedra"},

    {"surface", "name", KeyType::text, "", any, "", required_key, "a name not taken yet"},
    {"surface", "normal", KeyType::direction, "", any, "", optional_key, "of the plane; any length"},
    {"surface", "point", KeyType::vector, "m", any, "", optional_key, "on the plane; needed with normal"},
    {"surface", "tolerance", KeyType::number, "", KeyRange{.low = 0.0, .high = 0.1}, "", "1e-6",
     "distance of the corners from the plane, as a share of the diagonal of the body"},
    {"surface", "nodes", KeyType::index_list, "", whole(0, 2147483647), "", optional_key,
     "of a [mesh]: the boundary faces all of whose corners are listed"},

    {"material", "youngs_modulus", KeyType::number, "Pa", above_zero, "", required_key, "E"},
    {"material", "poisson_ratio", KeyType::number, "",
     KeyRange{.low = -1.0, .high = 0.5, .why = "0.5 is the incompressible limit, where the bulk modulus is infinite"},
     "", required_key, "nu"},
    {"material", "dilatation", KeyType::choice, "", any, "standard|mean", "\"standard\"",
     "mean: volume change averaged over each hexahedron, does not lock as nu nears 0.5"},
    {"material", "kinematics", KeyType::choice, "", any, "linear|corotational", "\"linear\"",
     "corotational: strain measured in a frame that turns with the cell"},

    {"support", "surface", KeyType::text, "", any, "", required_key, "where"},
    {"support", "normal", KeyType::direction, "", any, "", optional_key,
     "hold only the displacement along it: a sliding plane"},
    {"support", "components", KeyType::axes, "", any, "", optional_key,
     "hold only these components; without normal and components all are held"},
    {"support", "displacement", KeyType::vector, "m", any, "", "[0, 0, 0]", "constant part"},
    {"support", "gradient", KeyType::matrix, "", any, "", "[[0, 0, 0], [0, 0, 0], [0, 0, 0]]",
     "linear part: row i, column j is du_i / dX_j"},

    {"load", "surface", KeyType::text, "", any, "", optional_key, "where; needed with traction and total_force"},
    {"load", "traction", KeyType::vector, "Pa", any, "", optional_key, "force per rest area"},
    {"load", "total_force", KeyType::vector, "N", any, "", optional_key, "force on the whole surface"},
    {"load", "share", KeyType::choice, "", any, "area|node", "\"area\"",
     "of a total force: by area, or an equal part to each node"},
    {"load", "body_force", KeyType::vector, "N/m^3", any, "", optional_key, "on the whole body; takes no surface"},

    {"refine", "all", KeyType::boolean, "", any, "", "false", "every cell; else those whose centre is in a region"},
    {"refine", "min", KeyType::vector, "m", any, "", optional_key, "lower corner of the region"},
    {"refine", "max", KeyType::vector, "m", any, "", optional_key, "upper corner of the region"},
    {"refine", "template", KeyType::refinement, "", any, "", "\"2x2x2\"", "children along each of the cell's own axes"},
    {"refine", "levels", KeyType::integer, "", whole(1, 20), "", "1", "times over"},

    {"adapt", "steps", KeyType::integer, "", whole(0, 1000), "", required_key, "refinements at most"},
    {"adapt", "marking", KeyType::choice, "", any, "maximum|bulk|fraction|threshold", "\"maximum\"",
     "cells with eta_e >= theta max; the fewest with theta^2 of sum eta_e^2; the theta largest; eta_e > threshold"},
    {"adapt", "theta", KeyType::number, "", KeyRange{.low = 0.0, .high = 1.0, .high_allowed = true}, "", "0.3",
     "of maximum, bulk and fraction"},
    {"adapt", "threshold", KeyType::number, "J^0.5", above_zero, "", optional_key,
     "needed with marking = \"threshold\""},
    {"adapt", "policy", KeyType::choice, "", any, "template|directional", "\"template\"",
     "directional: the cheapest template that reduces the cell's error where it is"},
    {"adapt", "template", KeyType::refinement, "", any, "", "\"2x2x2\"", "of policy = \"template\""},
    {"adapt", "tolerance", KeyType::number, "", KeyRange{.low = 0.0, .high = 1.0, .low_allowed = true}, "", "0.0",
     "stop when the relative estimated error eta is at most this; 0: never"},
    {"adapt", "max_depth", KeyType::integer, "", whole(0, 20), "", "20", "cells that were refined so often are left"},
    {"adapt", "max_dofs", KeyType::integer, "", whole(1, 2147483647), "", "2000000",
     "no further step from this many degrees of freedom on"},
    {"adapt", "estimator", KeyType::choice, "", any, "spr", "\"spr\"", "superconvergent patch recovery"},

    {"solver", "method", KeyType::choice, "", any, "automatic|direct|multigrid", "\"automatic\"",
     "sparse Cholesky, or conjugate gradients with multigrid"},
    {"solver", "relative_residual", KeyType::number, "",
     KeyRange{.low = 1e-14, .high = 1.0, .low_allowed = true, .why = "rounding allows no less than 1e-14"}, "", "1e-6",
     "of each linear solve: |b - A x| / |b|"},
    {"solver", "iterations", KeyType::integer, "", whole(1, 1000000), "", "1000", "of each linear solve at most"},
    {"solver", "newton_iterations", KeyType::integer, "", whole(1, 10000), "", "50", "at most, corotational only"},
    {"solver", "newton_residual", KeyType::number, "",
     KeyRange{.low = 1e-14, .high = 1.0, .low_allowed = true, .why = "rounding allows no less than 1e-14"}, "", "1e-8",
     "force out of balance over the force applied, corotational only"},

    {"quantity", "kind", KeyType::choice, "", any, "energy|displacement", required_key,
     "twice the strain energy, the integral of strain : stress [J], or a displacement [m]"},
    {"quantity", "name", KeyType::text, "", any, "", optional_key, "of the result; none: the kind"},
    {"quantity", "point", KeyType::vector, "m", any, "", optional_key,
     "rest position of the material point; needed with displacement"},
};

std::string plain(double value) {
  std::ostringstream text;
  text.precision(12);
  text << value;
  return text.str();
}

std::string range_words(const KeyRange& range) {
  const bool below = range.low > -infinity, above = range.high < infinity;
  std::string words;
  if (below && above)
    words = (range.low_allowed ? " in [" : " in (") + plain(range.low) + ", " + plain(range.high) +
            (range.high_allowed ? "]" : ")");
  else if (below)
    words = (range.low_allowed ? " >= " : " > ") + plain(range.low);
  else if (above)
    words = (range.high_allowed ? " <= " : " < ") + plain(range.high);
  if (!range.why.empty()) words += " (" + std::string(range.why) + ")";
  return words;
}

std::string choice_words(std::string_view choices) {
  std::string words = "\"";
  for (const char c : choices) words += c == '|' ? std::string("\" or \"") : std::string(1, c);
  return words + "\"";
}

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string_view>& candidates) {
  constexpr std::size_t longest_sensible = 64;
  if (word.size() > longest_sensible) return {};
  std::string_view best;
  int best_distance = 2 + static_cast<int>(word.size() / 4);  // exclusive
  for (const std::string_view candidate : candidates) {
    // A key that was cut short or written out is nearer than its edit distance says.
    const bool part = word.size() >= 3 && (candidate.find(word) != std::string_view::npos ||
                                           (candidate.size() >= 3 && word.find(candidate) != std::string_view::npos));
    const int distance = part ? 1 : edit_distance(word, candidate);
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = candidate;
  }
  return std::string(best);
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates) {
  const std::string best = nearest(word, candidates);
  std::string words = best.empty() ? "" : ", the nearest known one is \"" + best + "\"";
  words += ", allowed ";
  for (const std::string_view candidate : candidates)
    words += (candidate == candidates.front() ? "" : ", ") + std::string(candidate);
  return words;
}

}  // namespace

std::span<const SceneSection> scene_sections() { return sections; }
std::span<const SceneKey> scene_keys() { return keys; }

const SceneSection* find_section(std::string_view name) {
  const auto* found = std::find_if(std::begin(sections), std::end(sections), [&](auto& s) { return s.name == name; });
  return found == std::end(sections) ? nullptr : found;
}

const SceneKey* find_key(std::string_view section, std::string_view key) {
  const auto* found = std::find_if(std::begin(keys), std::end(keys),
                                   [&](auto& row) { return row.section == section && row.key == key; });
  return found == std::end(keys) ? nullptr : found;
}

std::string allowed_values(const SceneKey& key) {
  const std::string range = range_words(key.range);
  const std::string each = range.empty() ? "" : ", each" + range;
  switch (key.type) {
    case KeyType::text:
      return "a text that is not empty";
    case KeyType::choice:
      return choice_words(key.choices);
    case KeyType::boolean:
      return "true or false";
    case KeyType::integer:
      return "a whole number" + range;
    case KeyType::number:
      return "a finite number" + range;
    case KeyType::integers3:
      return "three whole numbers" + each;
    case KeyType::vector:
      return "three finite numbers" + each;
    case KeyType::direction:
      return "three finite numbers, not all zero";
    case KeyType::matrix:
      return "three rows of three finite numbers";
    case KeyType::axes:
      return "one to three of \"x\", \"y\", \"z\", none twice";
    case KeyType::refinement:
      return "a text \"NxMxK\", N, M, K from 1 to 4 and not all 1 (tetrahedra: \"2x2x2\" only)";
    case KeyType::points:
      return "a list of one or more triples of finite numbers";
    case KeyType::index_list:
      return "a list of one or more whole numbers" + each;
    case KeyType::index_lists:
      return "a list of one or more lists of whole numbers" + each;
  }
  return {};
}

std::string suggest_key(std::string_view section, std::string_view word) {
  std::vector<std::string_view> candidates;
  for (const SceneKey& row : keys)
    if (row.section == section) candidates.push_back(row.key);
  return suggestion(word, candidates);
}

std::string suggest_section(std::string_view word) {
  std::vector<std::string_view> candidates;
  for (const SceneSection& row : sections)
    if (!row.name.empty()) candidates.push_back(row.name);
  return suggestion(word, candidates);
}

}  // namespace finegauge
