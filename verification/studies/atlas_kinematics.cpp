#include "verification/studies/atlas_kinematics.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>

#include "core/elasticity/cell_response.hpp"
#include "verification/studies/atlas_scene.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/tissue_samples.hpp"

namespace finegauge {
namespace {

/// The turn about a unit axis by π - δ. Its sine and cosine are those of δ, so that δ may be far below the spacing of
/// doubles at π.
Eigen::Matrix3d almost_half_turn(const Eigen::Vector3d& axis, double delta) {
  const double s = std::sin(delta), c = -std::cos(delta);
  Eigen::Matrix3d cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return c * Eigen::Matrix3d::Identity() + s * cross + (1.0 - c) * axis * axis.transpose();
}

std::vector<Eigen::Vector3d> axes_to_turn_about() {
  std::vector<Eigen::Vector3d> axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 1, 0), {0, 1, -1}, {1, 1, 1}, {1, -2, 3}, {1, 1e-8, 0}})
    axes.push_back(axis.normalized());
  return axes;
}

// One cell.

AtlasPoint turned_cell(double delta) {
  Material material{.youngs_modulus = 1.0, .poisson_ratio = 0.3};
  material.kinematics = Kinematics::corotational;
  std::mt19937 generator(5);
  double largest_force = 0.0, largest_error = 0.0;
  for (const CellShape shape : {CellShape::hexahedron, CellShape::tetrahedron})
    for (const double distortion : {0.0, 0.15})
      for (const Eigen::Vector3d& axis : axes_to_turn_about()) {
        const CellVectors X = sample_cell(shape, distortion, generator);
        const Eigen::Matrix3d turn = almost_half_turn(axis, delta);
        const CellVectors x = affine_image(shape, turn, Eigen::Vector3d(3.0, -1.0, 2.0), X);
        const CellGeometry geometry = cell_geometry(shape, X);
        // Stretched before it is turned: the rotation is the same.
        const Eigen::Matrix3d stretched = turn * Eigen::Vector3d(1.3, 1.0, 0.5).asDiagonal();
        const CellVectors longer = affine_image(shape, stretched, Eigen::Vector3d(3.0, -1.0, 2.0), X);
        keep_largest(largest_error, largest_entry(cell_rotation(geometry, material, longer) - turn));
        const Eigen::Matrix3d R = cell_rotation(geometry, material, x);
        keep_largest(largest_error, largest_entry(R - turn));
        keep_largest(largest_force, largest_entry(cell_force(cell_stiffness(shape, geometry, material), R, X, x)));
      }
  AtlasChecks checks;
  // A dozen operations on numbers up to ten, times gradients up to five: some hundred times the unit round-off.
  checks.add("error of the rotation", largest_error, 3e-14);
  checks.add("force of a turned cell over E h^2", largest_force, 3e-14);
  return checks.point(delta);
}

// A block whose root is turned: all of it has to follow as a rigid body.

constexpr const char* turned_scene = R"(name = "turned"
units = "none"
[box]
size = [2, 1, 1]
cells = [2, 1, 1]
[[refine]]
min = [1, 0, 0]
max = [2, 1, 1]
template = "2x3x3"
[material]
youngs_modulus = 1e4
poisson_ratio = 0.3
kinematics = "corotational"
[[support]]
surface = "x_min"
gradient = $GRADIENT
[solver]
newton_iterations = 200
[[quantity]]
kind = "energy"
)";

std::string turned_text(const Eigen::Matrix3d& turn) {
  const Eigen::Matrix3d G = turn - Eigen::Matrix3d::Identity();
  std::string gradient = "[";
  for (int i = 0; i < 3; ++i)
    gradient += (i ? ", " : "") + filled("[$A, $B, $C]", {{"A", G(i, 0)}, {"B", G(i, 1)}, {"C", G(i, 2)}});
  std::string text = turned_scene;
  return text.replace(text.find("$GRADIENT"), 9, gradient + "]");
}

double rigid_error(const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::Matrix3d& turn) {
  return largest_entry(mesh.nodes + u - turn * mesh.nodes);
}

AtlasPoint turned_cold(double delta) {
  const Eigen::Matrix3d turn = almost_half_turn(Eigen::Vector3d(1, -2, 3).normalized(), delta);
  const std::string text = turned_text(turn);
  return scene_point(delta, text, [&] {
    const StaticEnd end = solve_scene(text);
    if (const std::string why = why_unsolved(end.solution.equilibrium); !why.empty()) return refusal(delta, why);
    AtlasChecks checks;
    checks.add("distance from the turned block over its size",
               rigid_error(end.solution.discretization.mesh, end.solution.equilibrium.u, turn) / 2.0, 1e-6);
    return checks.point(delta);
  });
}

AtlasPoint turned_warm(double delta) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 3).normalized();
  const Scene scene = scene_from_text(turned_text(Eigen::Matrix3d::Identity()));
  RefinementForest forest(base_mesh(scene));
  forest.refine(1, {{2, 3, 3}});
  constexpr int steps = 12;
  std::optional<StaticSolution> solution;
  Eigen::Matrix3d turn;
  FactorCache factors;
  for (int step = 1; step <= steps; ++step) {
    const double angle = std::numbers::pi * step / steps;
    turn = step == steps ? almost_half_turn(axis, delta) : Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    StaticProblem problem;
    problem.material = scene.material;
    problem.solver = scene.solver;
    problem.supports = {
        {"x_min", std::nullopt, [turn](const Eigen::Vector3d& X) -> Eigen::Vector3d { return turn * X - X; }}};
    StaticSolution next = solve_static(forest, problem, solution ? &*solution : nullptr, factors);
    if (const std::string why = why_unsolved(next.equilibrium); !why.empty())
      return refusal(delta, "step " + std::to_string(step) + " of " + std::to_string(steps) + " " + why);
    solution = std::move(next);
  }
  AtlasChecks checks;
  checks.add("distance from the turned block over its size",
             rigid_error(solution->discretization.mesh, solution->equilibrium.u, turn) / 2.0, 1e-6);
  return checks.point(delta);
}

// A block that was crushed and is let go, held by its root: it has to come back to its own shape.

TissueProblem released_problem() {
  TissueProblem problem;
  problem.material = {.youngs_modulus = 1e4, .poisson_ratio = 0.3, .kinematics = Kinematics::corotational};
  problem.supports = {{"x_min", std::nullopt, {}}};
  // The waves of a metre of this stuff take half a second.
  problem.mass_damping = 2.0;
  problem.stiffness_damping = 0.02;
  return problem;
}

RefinementForest released_forest() {
  BoxMeshOptions box;
  box.size = {2.0, 1.0, 1.0};
  box.cells = {2, 1, 1};
  RefinementForest forest(box_mesh(box));
  forest.refine(1, {{2, 3, 3}});
  return forest;
}

/// x = c + S (X - c) but for the root, which is held.
Eigen::Matrix3Xd crushed(const Discretization& d, const Eigen::Matrix3d& S, const Eigen::Vector3d& centre) {
  const Eigen::Matrix3Xd from_centre = d.mesh.nodes.colwise() - centre;
  Eigen::VectorXd reduced = gather(d.hanging, Eigen::Matrix3Xd((S - Eigen::Matrix3d::Identity()) * from_centre));
  impose(d.supports, reduced);
  return expand(d.hanging, reduced);
}

/// Cells along x shrink to the part s of their length, or for s < 0 turn inside out.
Eigen::Matrix3d flattened_by(double s) { return Eigen::Vector3d(s, 1.0, 1.0).asDiagonal(); }
/// Cells shrink across to needles.
Eigen::Matrix3d thinned_by(double s) { return Eigen::Vector3d(1.0, s, s).asDiagonal(); }

AtlasPoint released_static(double value, const Eigen::Matrix3d& S) {
  const TissueProblem tissue = released_problem();
  const RefinementForest forest = released_forest();
  const Discretization d = discretize(forest, tissue.material, tissue.supports);
  EquilibriumOptions options;
  options.method = LinearMethod::direct;
  options.newton_iterations = 200;
  const Equilibrium end =
      solve_equilibrium(d, {}, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()), crushed(d, S, {0.0, 0.5, 0.5}), options);
  if (const std::string why = why_unsolved(end); !why.empty()) return refusal(value, why);
  AtlasChecks checks;
  checks.add("distance from the shape at rest over the size", largest_entry(end.u) / 2.0, 1e-6);
  return checks.point(value);
}

AtlasPoint released_in_time(double value, const Eigen::Matrix3d& S) {
  const TissueProblem problem = released_problem();
  const TissueMesh mesh = build_tissue_mesh(released_forest(), problem);
  TissueState state = state_at_rest(mesh);
  state.u = crushed(mesh.d, S, {0.0, 0.5, 0.5});
  FactorCache factors;
  TissueSystem system;
  constexpr double tau = 0.02;
  constexpr int steps = 400;
  for (int step = 0; step < steps; ++step) {
    const TissueStepReport report =
        step_tissue(mesh, problem, step * tau, tau, {}, direct_linear_solve(factors), system, state);
    if (!report.converged) return refusal(value, "step " + std::to_string(step + 1) + " did not converge and says so");
  }
  AtlasChecks checks;
  checks.add("distance from the shape at rest over the size, 8 s later", largest_entry(state.u) / 2.0, 1e-3);
  return checks.point(value);
}

const std::vector<double> shares = {0.0, 1e-12, 1e-8, 1e-4, 1e-2, 0.1, 0.5, 0.9, 1.0};
const std::vector<double> more_shares = {1e-300, 1e-16, 1e-15, 1e-14, 1e-13, 1e-10, 1e-9, 1e-6,
                                         1e-5,   1e-3,  0.2,   0.3,   0.7,   0.95,  0.99, 0.999};

}  // namespace

std::vector<AtlasAxis> kinematics_axes() {
  std::vector<AtlasAxis> axes;
  const std::vector<double> deltas = {0.0, 1e-16, 1e-15, 1e-12, 1e-8, 1e-4, 1e-2, 1.0};
  const std::vector<double> more_deltas = {1e-300, 1e-14, 1e-13, 1e-10, 1e-6, 1e-3, 0.1, 0.3, 2.0, 3.0};
  axes.push_back({.group = "kinematics",
                  .name = "half_turn_cell",
                  .unit = "rad",
                  .about = "pi minus the turn of a cell about any axis, both cell shapes",
                  .truth = "the turn itself, and no force",
                  .normal = 1.0,
                  .values = deltas,
                  .more_values = more_deltas,
                  .at = turned_cell,
                  .safe = {0.0, 1.0},
                  .answered = {0.0, 1.0},
                  .reason = "none: the polar decomposition knows no angle, and remembers no earlier rotation"});
  axes.push_back({.group = "kinematics",
                  .name = "half_turn_warm",
                  .unit = "rad",
                  .about = "pi minus the turn of a block by its root, in twelve steps",
                  .truth = "the turned block",
                  .normal = 1.0,
                  .values = deltas,
                  .more_values = more_deltas,
                  .at = turned_warm,
                  .safe = {0.0, 1.0},
                  .answered = {0.0, 1.0},
                  .reason = "none: the polar decomposition knows no angle, and remembers no earlier rotation"});
  axes.push_back({.group = "kinematics",
                  .name = "half_turn_cold",
                  .unit = "rad",
                  .about = "pi minus the turn of a block by its root, all at once from rest",
                  .truth = "the turned block",
                  .normal = 1.0,
                  .values = deltas,
                  .more_values = more_deltas,
                  .at = turned_cold,
                  .safe = {0.0, 1.0},
                  .answered = {0.0, 1.0},
                  .reason = "none: the polar decomposition knows no angle, and remembers no earlier rotation"});
  axes.push_back({.group = "kinematics",
                  .name = "flattening",
                  .unit = "",
                  .about = "what is left of the length of a block's cells when it is let go; static",
                  .truth = "the shape at rest",
                  .normal = 1.0,
                  .values = shares,
                  .more_values = more_shares,
                  .at = [](double s) { return released_static(s, flattened_by(s)); },
                  .safe = {0.0, 1.0},
                  .answered = {0.0, 1.0},
                  .reason = "none: a flat cell has one nearest proper rotation"});
  axes.push_back(
      {.group = "kinematics",
       .name = "inversion",
       .unit = "",
       .about = "how far a block's cells are turned inside out, over their length, when it is let go; static",
       .truth = "the shape at rest",
       .normal = 0.1,
       .values = shares,
       .more_values = more_shares,
       .at = [](double s) { return released_static(s, flattened_by(-s)); },
       .safe = {0.0, 1.0},
       .answered = {0.0, 1.0},
       .reason = "none: of the rotations that are equally near to an exact mirror image the one that turns least is "
                 "taken, so "
                 "that neighbours agree"});
  axes.push_back({.group = "kinematics",
                  .name = "inversion_in_time",
                  .unit = "",
                  .about = "the same, followed for 8 s with damping",
                  .truth = "the shape at rest",
                  .normal = 0.1,
                  .values = {0.0, 1e-12, 1e-4, 0.1, 0.9, 1.0},
                  .more_values = more_shares,
                  .at = [](double s) { return released_in_time(s, flattened_by(-s)); },
                  .safe = {0.0, 1.0},
                  .answered = {0.0, 1.0},
                  .reason = "none: of the rotations that are equally near to an exact mirror image the one that turns "
                            "least is taken, so "
                            "that neighbours agree"});
  axes.push_back({.group = "kinematics",
                  .name = "thinning",
                  .unit = "",
                  .about = "what is left of the width of a block's cells when it is let go; static",
                  .truth = "the shape at rest",
                  .normal = 1.0,
                  .values = shares,
                  .more_values = more_shares,
                  .at = [](double s) { return released_static(s, thinned_by(s)); },
                  .safe = {0.0, 1.0},
                  .answered = {0.0, 1.0},
                  .reason =
                      "none: of the rotations that are equally near to a line the one that turns least is taken, so "
                      "that neighbours agree"});
  axes.push_back({.group = "kinematics",
                  .name = "thinning_in_time",
                  .unit = "",
                  .about = "the same, followed for 8 s with damping",
                  .truth = "the shape at rest",
                  .normal = 1.0,
                  .values = {0.0, 1e-12, 1e-4, 0.1, 0.5, 1.0},
                  .more_values = more_shares,
                  .at = [](double s) { return released_in_time(s, thinned_by(s)); },
                  .safe = {0.0, 1.0},
                  .answered = {0.0, 1.0},
                  .reason =
                      "none: of the rotations that are equally near to a line the one that turns least is taken, so "
                      "that neighbours agree"});
  return axes;
}

}  // namespace finegauge
