#include "core/scene/dynamics_reader.hpp"

#include "core/scene/geometry_reader.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/plain_number.hpp"

namespace finegauge {
namespace {

constexpr double most_frames = 1e7;  // a document with a row for each of them is still some gigabytes

/// Of two thresholds the one that coarsens must be the lower; told at the key that the scene gives.
void check_order(const SectionReader& reader, const char* lower_key, double lower, const char* upper_key,
                 double upper) {
  if (lower < upper) return;
  const bool at_lower = reader.has(lower_key);
  reader.refuse(at_lower ? lower_key : upper_key,
                "found " + plain_number(at_lower ? lower : upper) + ", allowed a number " +
                    (at_lower ? std::string("below ") + upper_key : std::string("above ") + lower_key) + ", " +
                    plain_number(at_lower ? upper : lower) + ", or the mesh would chatter");
}

FrameAdaptRules read_frame_adapt(const SectionReader& reader, CellShape shape) {
  FrameAdaptRules rules;
  rules.refine_above = reader.number("theta");
  rules.coarsen_below = reader.number("coarsen_below");
  check_order(reader, "coarsen_below", rules.coarsen_below, "theta", rules.refine_above);
  rules.tolerance = reader.number("tolerance");
  rules.local_tolerance = reader.number("local_tolerance");
  rules.refine_at = reader.number("refine_at");
  rules.coarsen_at = reader.number("coarsen_at");
  check_order(reader, "coarsen_at", rules.coarsen_at, "refine_at", rules.refine_at);
  rules.energy_floor = reader.number("energy_floor");
  rules.dwell = reader.integer("dwell");
  rules.every = reader.integer("every");
  rules.release = reader.integer("release");
  rules.max_depth = reader.integer("max_depth");
  rules.max_dofs = reader.integer("max_dofs");
  rules.directional = reader.text("policy") == "directional";
  rules.refinement = read_template(reader, shape);
  return rules;
}

StepSolverOptions read_step_solver(const SectionReader& reader) {
  StepSolverOptions solver;
  solver.method = reader.text("step_method") == "kept" ? StepMethod::kept : StepMethod::plain;
  solver.linear.relative_residual = reader.number("relative_residual");
  solver.linear.iterations = reader.integer("iterations");
  return solver;
}

double read_duration(const SectionReader& reader, const std::optional<SceneNeedle>& needle, double time_step) {
  double duration = 0.0;
  if (reader.has("duration")) {
    duration = reader.number("duration");
  } else {
    if (!needle || needle->drive.strokes.empty())
      reader.refuse_missing("duration", needle ? "required in a scene without [[stroke]]"
                                               : "required in a moving scene without a needle");
    for (const Stroke& stroke : needle->drive.strokes) duration += stroke.duration;
  }
  const char* key = reader.has("duration") ? "duration" : "time_step";
  if (!(duration >= time_step))
    reader.refuse(key, "found " + plain_number(reader.has("duration") ? duration : time_step) +
                           " s, allowed a duration (" + plain_number(duration) + " s) of at least one time step (" +
                           plain_number(time_step) + " s)");
  if (!(duration / time_step <= most_frames))
    reader.refuse(key, "found " + plain_number(duration / time_step) +
                           " frames of time_step in the duration, allowed at most " + plain_number(most_frames));
  return duration;
}

}  // namespace

void read_dynamics(const SceneDocument& document, CellShape shape, Scene& scene) {
  const auto section = [&](const std::string& name) {
    return SectionReader(document, name, name, document.root().get_as<toml::table>(name));
  };
  const SectionReader reader = section("dynamics");
  SceneDynamics dynamics;
  dynamics.time_step = reader.number("time_step");
  dynamics.duration = read_duration(reader, scene.needle, dynamics.time_step);
  dynamics.density = reader.number("density");
  dynamics.mass_damping = reader.number("mass_damping");
  dynamics.stiffness_damping = reader.number("stiffness_damping");
  dynamics.gravity = reader.vector("gravity");
  dynamics.step.newton_iterations = reader.integer("newton_iterations");
  dynamics.step.newton_residual = reader.number("newton_residual");
  dynamics.estimate_error = reader.boolean("estimate_error");
  if (reader.has("deadline")) dynamics.deadline_ms = reader.number("deadline");
  dynamics.solver = read_step_solver(section("solver"));
  if (document.root().contains("adapt") && section("adapt").boolean("enabled")) {
    if (!dynamics.estimate_error)
      reader.refuse("estimate_error", "found false, allowed true with [adapt], which needs it");
    dynamics.adapt = read_frame_adapt(section("adapt"), shape);
    dynamics.check_popping = section("adapt").boolean("check_popping");
    if (dynamics.check_popping && !scene.needle)
      section("adapt").refuse("check_popping", "found true, allowed only with [needle], whose force it compares");
  }
  scene.dynamics = dynamics;
}

}  // namespace finegauge
