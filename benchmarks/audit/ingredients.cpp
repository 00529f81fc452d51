#include "benchmarks/audit/ingredients.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace finegauge {
namespace {

std::string text(double value) {
  std::array<char, 40> buffer;
  std::snprintf(buffer.data(), buffer.size(), "%.9g", value);
  return buffer.data();
}

std::string text(const Eigen::Vector3d& value) {
  return "[" + text(value.x()) + ", " + text(value.y()) + ", " + text(value.z()) + "]";
}

std::string key(const std::string& name, const std::string& value) {
  std::string both = name;
  return both.append("=").append(value);
}

/// A needle of so many times the stiffness and a body of so small a share of the density are rigid and massless for
/// what can be seen, and still well within round-off.
constexpr double rigid = 1e4, massless = 1e-6;

/// Share of an attachment's way that is no motion. Not zero, which a scene may not say of an attachment that breathes.
constexpr double unmoved = 1e-9;

bool moves(const SceneAttachment& attachment) { return attachment.course && !attachment.displacement.isZero(0.0); }

void add_material(const Scene& scene, std::vector<Ingredient>& list) {
  const bool corotational = scene.material.kinematics == Kinematics::corotational;
  list.push_back({"corotation",
                  "strain measured in a frame that turns with the cell",
                  corotational,
                  {corotational ? "material.kinematics=linear" : "material.kinematics=corotational"}});
  const bool mean = scene.material.dilatation == Dilatation::mean;
  list.push_back({"locking_free_cells",
                  "volume change averaged over each cell",
                  mean,
                  {mean ? "material.dilatation=standard" : "material.dilatation=mean"}});
}

void add_dynamics(const Scene& scene, std::vector<Ingredient>& list) {
  const SceneDynamics& dynamics = *scene.dynamics;
  std::vector<std::string> light = {key("dynamics.density", text(massless * dynamics.density))};
  if (scene.needle) light.push_back(key("needle.density", text(massless * scene.needle->properties.density)));
  // Weight and damping of mass are forces of their own, with names of their own: they stay.
  if (!dynamics.gravity.isZero(0.0)) light.push_back(key("dynamics.gravity", text(dynamics.gravity / massless)));
  if (dynamics.mass_damping > 0.0)
    light.push_back(key("dynamics.mass_damping", text(dynamics.mass_damping / massless)));
  list.push_back({"inertia", "masses, a millionth of them left; weight and damping stay", true, light});
  if (dynamics.mass_damping > 0.0 || dynamics.stiffness_damping > 0.0)
    list.push_back(
        {"damping", "of mass and stiffness", true, {"dynamics.mass_damping=0", "dynamics.stiffness_damping=0"}});
  if (!dynamics.gravity.isZero(0.0)) list.push_back({"gravity", "on the body", true, {"dynamics.gravity=[0, 0, 0]"}});
  if (dynamics.adapt) {
    list.push_back({"adaptivity",
                    "a mesh that follows the error, and the estimate for it",
                    true,
                    {"adapt.enabled=false", "dynamics.estimate_error=false"}});
  } else {
    list.push_back({"adaptivity",
                    "a mesh that follows the error: one level of 2x2x2",
                    false,
                    {"adapt.enabled=true", "adapt.max_depth=1", "dynamics.estimate_error=true"}});
    if (dynamics.estimate_error)
      list.push_back(
          {"estimate", "the error of each frame, which nothing follows", true, {"dynamics.estimate_error=false"}});
  }
  if (scene.material.kinematics == Kinematics::corotational) {
    const bool several = dynamics.step.newton_iterations > 1;
    list.push_back({"newton", "several linear solves a frame", several,
                    several
                        ? std::vector<std::string>{"dynamics.newton_iterations=1"}
                        : std::vector<std::string>{"dynamics.newton_iterations=50", "dynamics.newton_residual=1e-4"}});
  }
  std::vector<std::string> still;
  for (std::size_t i = 0; i < scene.attachments.size(); ++i)
    if (moves(scene.attachments[i]))
      still.push_back(
          key("attachment[" + std::to_string(i) + "].displacement", text(unmoved * scene.attachments[i].displacement)));
  if (!still.empty()) list.push_back({"breathing", "attachments that move", true, still});
}

void add_needle(const SceneNeedle& needle, std::vector<Ingredient>& list) {
  const ContactRules& contact = needle.contact;
  list.push_back({"needle_flexibility",
                  "a needle that bends and shortens; else ten thousand times as stiff",
                  true,
                  {key("needle.youngs_modulus", text(rigid * needle.properties.youngs_modulus))}});
  if (contact.friction_in > 0.0 || contact.friction_out > 0.0)
    list.push_back({"friction", "of the shaft, both ways", true, {"contact.friction=0", "contact.friction_out=0"}});
  if (contact.surface_friction > 0.0)
    list.push_back({"surface_friction", "of the tip before puncture", true, {"contact.surface_friction=0"}});
  if (contact.clamping > 0.0)
    list.push_back({"clamping", "the grip of the tissue on the shaft", true, {"contact.clamping=0"}});
  if (contact.puncture_strength > 0.0)
    list.push_back({"puncture",
                    "a surface that resists",
                    true,
                    {"contact.puncture_strength=0", key("contact.cut_strength", text(contact.cut_strength))}});
  if (contact.cut_strength > 0.0)
    list.push_back({"cutting", "an inside that resists", true, {"contact.cut_strength=0"}});
  if (contact.coupling_radius > 0.0)
    list.push_back({"coupling_radius", "forces spread over a ring; else points", true, {"contact.coupling_radius=0"}});
}

}  // namespace

std::vector<Ingredient> scene_ingredients(const Scene& scene) {
  std::vector<Ingredient> list;
  add_material(scene, list);
  if (scene.dynamics) {
    add_dynamics(scene, list);
    if (scene.needle) add_needle(*scene.needle, list);
    return list;
  }
  if (scene.adapt)
    list.push_back({"adaptivity", "refinement by estimated error", true, {"adapt.enabled=false"}});
  else
    list.push_back(
        {"adaptivity", "refinement by estimated error: two steps", false, {"adapt.enabled=true", "adapt.steps=2"}});
  return list;
}

}  // namespace finegauge
