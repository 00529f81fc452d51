#include "core/scene/needle_reader.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/mesh/body_location.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/plain_number.hpp"
#include "core/scene/section_reader.hpp"

namespace finegauge {
namespace {

std::string short_text(double value) { return plain_number(value, 6); }
std::string short_text(const Eigen::Vector3d& v) {
  return "[" + short_text(v.x()) + ", " + short_text(v.y()) + ", " + short_text(v.z()) + "]";
}

SceneNeedle read_body(const SectionReader& reader) {
  SceneNeedle needle;
  needle.properties.youngs_modulus = reader.number("youngs_modulus");
  needle.properties.poisson_ratio = reader.number("poisson_ratio");
  needle.properties.radius = reader.number("radius");
  needle.properties.density = reader.number("density");
  needle.base = reader.vector("base");
  needle.tip = reader.vector("tip");
  const Eigen::Vector3d chord = needle.tip - needle.base;
  // Below this their difference is mostly the rounding of the two.
  constexpr double least_length = 1e-9;
  const double size = std::max(needle.base.lpNorm<Eigen::Infinity>(), needle.tip.lpNorm<Eigen::Infinity>());
  if (!(chord.lpNorm<Eigen::Infinity>() > least_length * size))
    reader.refuse("tip", "found " + short_text(needle.tip) + ", allowed a point that is not the base");
  needle.elements = reader.integer("elements");
  needle.drive.base_turns = reader.text("base_rotation") == "free";
  needle.drive.guided = reader.boolean("guided");
  needle.imperfection = reader.number("imperfection");
  if (needle.imperfection > 0.0) {
    if (!reader.has("imperfection_direction"))
      reader.refuse_missing("imperfection_direction", "needed with imperfection");
    const Eigen::Vector3d axis = chord.stableNormalized();
    const Eigen::Vector3d direction = reader.vector("imperfection_direction").stableNormalized();
    const Eigen::Vector3d across = direction - axis.dot(direction) * axis;
    constexpr double least_angle = 1e-6;  // to the needle [rad]
    if (!(across.norm() > least_angle))
      reader.refuse("imperfection_direction", "found a direction along the needle, allowed one across it");
    needle.imperfection_direction = across.normalized();
  }
  return needle;
}

Stroke read_stroke(const SectionReader& reader) {
  if (reader.has("displacement") == reader.has("dwell"))
    reader.refuse_missing("displacement", "exactly one of displacement (with speed) and dwell");
  if (reader.has("dwell")) {
    if (reader.has("speed")) reader.refuse("speed", "found beside dwell, allowed with displacement only");
    return {Eigen::Vector3d::Zero(), reader.number("dwell")};
  }
  if (!reader.has("speed")) reader.refuse_missing("speed", "needed with displacement");
  const Eigen::Vector3d displacement = reader.vector("displacement");
  const double duration = displacement.stableNorm() / reader.number("speed");
  if (displacement.isZero(0.0)) reader.refuse("displacement", "found [0, 0, 0], allowed a motion; to rest is a dwell");
  if (!(duration > 0.0 && std::isfinite(duration)))
    reader.refuse("speed", "found a stroke of " + short_text(duration) + " s, allowed a finite duration > 0");
  return {displacement, duration};
}

void read_contact(const SectionReader& reader, SceneNeedle& needle) {
  ContactRules& rules = needle.contact;
  const auto number_or = [&](const char* key, double value) { return reader.has(key) ? reader.number(key) : value; };
  rules.puncture_strength = reader.number("puncture_strength");
  rules.cut_strength = number_or("cut_strength", rules.puncture_strength);
  rules.cut_advance = reader.number("cut_advance");
  const double length = (needle.tip - needle.base).stableNorm();
  if (!(rules.cut_advance <= length))
    reader.refuse("cut_advance", "found " + short_text(rules.cut_advance) + ", allowed at most the needle's length, " +
                                     short_text(length));
  rules.friction_in = reader.number("friction");
  rules.friction_out = number_or("friction_out", rules.friction_in);
  rules.surface_friction = reader.number("surface_friction");
  rules.clamping = reader.number("clamping");
  rules.coupling_radius = number_or("coupling_radius", needle.properties.radius);
  needle.interaction.weight = reader.number("weight");
  needle.interaction.tolerance = reader.number("tolerance");
  needle.interaction.iterations = reader.integer("iterations");
}

Eigen::Matrix3Xd rest_nodes(const SectionReader& reader, const SceneNeedle& needle) {
  try {
    return scene_needle(needle).rest_positions;
  } catch (const std::invalid_argument& defect) {
    reader.refuse(needle.imperfection > 0.0 ? "imperfection" : "tip",
                  std::string("found a needle that has no beams: ") + defect.what());
  }
}

/// The body at rest is what is known here; where it is during a stroke only the run can tell.
void check_outside(const SectionReader& reader, const BaseMesh& mesh, const SceneNeedle& needle) {
  const Eigen::Matrix3Xd nodes = rest_nodes(reader, needle);
  const Mesh rest = RefinementForest(mesh).leaf_mesh();
  const Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, rest.node_count());
  if (const auto meeting = chain_meeting(mesh, rest, u, nodes)) {
    const std::string place = short_text(meeting->position);
    if (meeting->kind == ChainMeeting::Kind::enters)
      reader.refuse("tip", "found a needle that enters the body at " + place +
                               ", allowed one that is outside of it at the start");
    reader.refuse(meeting->point == 0 ? "base" : "tip",
                  "found " + place +
                      (meeting->kind == ChainMeeting::Kind::inside ? " in the body" : " on the body's surface") +
                      ", allowed outside of the body, and not on its surface");
  }
  Eigen::Vector3d base = needle.base;
  for (std::size_t k = 0; k < needle.drive.strokes.size(); ++k) {
    const Eigen::Vector3d next = base + needle.drive.strokes[k].displacement;
    if (const auto hit = first_body_entry(mesh, rest, u, base, next))
      reader.refuse("base", "found a base that stroke[" + std::to_string(k) + "] takes into the body at " +
                                short_text(hit->position) + ", allowed strokes that keep it outside");
    base = next;
  }
}

}  // namespace

void check_needle_sections(const SceneDocument& document) {
  const toml::table& root = document.root();
  const auto line = [&](const char* name) { return root.get(name)->source().begin.line; };
  if (!root.contains("needle")) {
    for (const char* name : {"contact", "stroke"})
      if (root.contains(name)) document.fail(name, line(name), "found without [needle], allowed only with it");
    return;
  }
  for (const char* name : {"dynamics", "contact"})
    if (!root.contains(name))
      document.fail("needle", line("needle"),
                    std::string("found without [") + name + "], allowed only with [dynamics] and [contact]");
}

void read_needle(const SceneDocument& document, const BaseMesh& mesh, Scene& scene) {
  const toml::table& root = document.root();
  const SectionReader reader(document, "needle", "needle", root.get_as<toml::table>("needle"));
  SceneNeedle needle = read_body(reader);
  const toml::array* strokes = root.get_as<toml::array>("stroke");
  for (std::size_t i = 0; strokes && i < strokes->size(); ++i)
    needle.drive.strokes.push_back(read_stroke(
        SectionReader(document, "stroke", "stroke[" + std::to_string(i) + "]", strokes->get_as<toml::table>(i))));
  read_contact(SectionReader(document, "contact", "contact", root.get_as<toml::table>("contact")), needle);
  check_outside(reader, mesh, needle);
  scene.needle = needle;
}

}  // namespace finegauge
