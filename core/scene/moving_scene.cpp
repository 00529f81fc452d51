#include "core/scene/moving_scene.hpp"

#include <algorithm>
#include <cmath>

namespace finegauge {

int frame_count(const SceneDynamics& dynamics) {
  // Two seconds in steps of a hundredth are 200 frames, not 201 for the rounding of the quotient.
  constexpr double rounding = 1e-9;
  const double frames = dynamics.duration / dynamics.time_step;
  return std::max(1, static_cast<int>(std::ceil(frames * (1.0 - rounding))));
}

Needle scene_needle(const SceneNeedle& needle) {
  if (needle.imperfection == 0.0) return straight_needle(needle.properties, needle.base, needle.tip, needle.elements);
  Eigen::Matrix3Xd nodes(3, needle.elements + 1);
  for (int i = 0; i <= needle.elements; ++i) {
    const double share = static_cast<double>(i) / needle.elements;
    nodes.col(i) = needle.base + share * (needle.tip - needle.base) +
                   share * share * needle.imperfection * needle.imperfection_direction;
  }
  return chain_of_beams(round_section(needle.properties), nodes, needle.imperfection_direction);
}

MotionProblem motion_problem(const Scene& scene) {
  const SceneDynamics& dynamics = scene.dynamics.value();
  MotionProblem problem;
  problem.tissue.material = scene.material;
  problem.tissue.density = dynamics.density;
  problem.tissue.mass_damping = dynamics.mass_damping;
  problem.tissue.stiffness_damping = dynamics.stiffness_damping;
  problem.tissue.gravity = dynamics.gravity;
  problem.tissue.supports = support_conditions(scene);
  problem.tissue.springs = spring_supports(scene);
  problem.tissue.loads = scene.loads;
  problem.tissue.body = body_force(scene);
  problem.time_step = dynamics.time_step;
  problem.step = dynamics.step;
  problem.solver = dynamics.solver;
  problem.estimate_error = dynamics.estimate_error;
  problem.estimator = scene.estimator;
  problem.adapt = dynamics.adapt;
  return problem;
}

InsertionProblem insertion_problem(const Scene& scene) {
  const SceneNeedle& needle = scene.needle.value();
  return {motion_problem(scene), scene_needle(needle), needle.drive, needle.contact, needle.interaction};
}

}  // namespace finegauge
