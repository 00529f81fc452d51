#include "verification/studies/estimator_ladder.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "core/adapt/apply_refinements.hpp"
#include "core/adapt/marking.hpp"
#include "core/equilibrated_estimate.hpp"
#include "core/stopwatch.hpp"
#include "verification/studies/estimator_kinds.hpp"
#include "verification/studies/problem_parts.hpp"
#include "verification/support/percentile.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

namespace finegauge {

namespace {

constexpr double pi = std::numbers::pi;
constexpr std::array<const char*, 3> estimators = {"spr", "spr_edges", "equilibrated"};

BoxMeshOptions box(const Eigen::Vector3d& origin, const Eigen::Vector3d& size, std::array<int, 3> cells) {
  BoxMeshOptions options;
  options.origin = origin;
  options.size = size;
  options.cells = cells;
  return options;
}

LadderRung smooth_rung(const std::string& name, BaseMesh mesh, const ManufacturedSolution& solution,
                       const Material& material = {}) {
  LadderRung rung{name, RefinementForest(std::move(mesh)), {}, exact_field(solution, material)};
  rung.problem.material = material;
  rung.problem.body = rung.exact.body;
  hold_exactly(rung.exact, {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"}, rung.problem);
  return rung;
}

BaseMesh cube(std::array<int, 3> cells) {
  return box_mesh(box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones(), cells));
}

BaseMesh perturbed_cube(int n) {
  std::mt19937 generator(1);
  return distorted_box(box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones(), {n, n, n}), 0.2, generator);
}

/// The cells in [0, 1/2]³, each by the template that `of` tells for its number.
template <class Of>
void refine_octant(LadderRung& rung, int n, const Of& of) {
  int number = 0;
  for (int k = 0; k < n / 2; ++k)
    for (int j = 0; j < n / 2; ++j)
      for (int i = 0; i < n / 2; ++i) rung.forest.refine(i + n * (j + n * k), of(number++));
  rung.has_front = true;
}

LadderRung notch_rung(const std::string& name, CornerMode mode, int n, int refinements, double nu = 0.3) {
  LadderRung rung{name, RefinementForest(notched_square(n, n, n / 2)), {}, {}};
  rung.problem.material.poisson_ratio = nu;
  rung.exact = corner_field(mode, 1.5 * pi, {0.0, 0.0}, 0.75 * pi, rung.problem.material);
  hold_exactly(rung.exact, {"x_min", "x_max", "y_min", "y_max"}, rung.problem);
  hold_plane(rung.problem);
  rung.refinements = refinements;
  rung.singular = true;
  return rung;
}

/// The upper half of a body with a crack along y = 0, x > 0: symmetric, so a roller before its tip.
LadderRung crack_rung(const std::string& name, int n, int refinements) {
  BaseMesh mesh = box_mesh(box({-1.0, 0.0, 0.0}, {2.0, 1.0, 0.5}, {2 * n, n, n / 2}));
  for (const BaseFace& face : mesh.surfaces.at("y_min")) {
    const auto& corners = hexahedron_faces[face.face];
    double x = 0.0;
    for (const int corner : corners) x += mesh.nodes(0, mesh.cells[face.cell][corner]);
    if (x < 0.0) mesh.surfaces["ahead"].push_back(face);
  }
  LadderRung rung{name, RefinementForest(std::move(mesh)), {}, {}};
  rung.exact = corner_field(CornerMode::opening, 2.0 * pi, {0.0, 0.0}, pi, rung.problem.material);
  hold_exactly(rung.exact, {"x_min", "x_max", "y_max"}, rung.problem);
  rung.problem.supports.push_back({"ahead", Eigen::Vector3d(Eigen::Vector3d::UnitY()), {}});
  hold_plane(rung.problem);
  rung.refinements = refinements;
  rung.singular = true;
  return rung;
}

/// A quarter space, clamped on x = 0 and free on y = 0.
LadderRung rim_rung(const std::string& name, int n, int refinements, double nu) {
  LadderRung rung{
      name, RefinementForest(box_mesh(box(Eigen::Vector3d::Zero(), {1.0, 1.0, 0.5}, {n, n, n / 2}))), {}, {}};
  rung.problem.material.poisson_ratio = nu;
  rung.exact = clamped_corner_field(0.0, 0.5 * pi, {0.0, 0.0}, rung.problem.material);
  hold_exactly(rung.exact, {"x_max", "y_max"}, rung.problem);
  rung.problem.supports.push_back({"x_min", std::nullopt, {}});
  hold_plane(rung.problem);
  rung.refinements = refinements;
  rung.singular = true;
  return rung;
}

/// The paper's L-shape as this project reads it, with the energy of its exact solution: 2 × 0.04602075 ± 1e-7 (graded
/// cubic meshes; `finegauge reproduce lshape --full` computes it again).
LadderRung lshape_rung(int refinements) {
  BoxMeshOptions options = box(Eigen::Vector3d::Zero(), {4.0, 4.0, 2.0}, {8, 8, 4});
  options.removed = RemovedBlock{{4, 0, 0}, {8, 4, 4}};
  LadderRung rung{"L-shape", RefinementForest(box_mesh(options)), {}, {}};
  rung.exact_energy = 2.0 * 0.04602075;
  rung.problem.supports.push_back({"x_max", std::nullopt, {}});
  rung.problem.supports.push_back({"y_max", Eigen::Vector3d(Eigen::Vector3d::UnitY()), {}});
  rung.problem.loads.push_back({"x_min", LoadKind::traction, {-1.0, 0.0, 0.0}});
  rung.refinements = refinements;
  rung.singular = true;
  return rung;
}

/// A cube clamped on one face and pulled at the other: four rims that meet in corners, and far from them little. The
/// energy is that of graded meshes with 90,000 degrees of freedom and what their own estimate adds, 2e-4 and 9e-4 of
/// it.
LadderRung block_rung(const std::string& name, int n, double nu, double exact_energy) {
  LadderRung rung{name, RefinementForest(cube({n, n, n})), {}, {}};
  rung.exact_energy = exact_energy;
  rung.problem.material.poisson_ratio = nu;
  rung.problem.supports.push_back({"z_min", std::nullopt, {}});
  rung.problem.loads.push_back({"z_max", LoadKind::traction, {0.0, 0.0, 1.0}});
  rung.singular = true;
  return rung;
}

void refine(LadderRung& rung, const StaticSolution& solution) {
  const Eigen::VectorXd& eta = solution.estimate.eta;
  std::vector<Refinement> refinements;
  for (const int cell : mark_maximum({eta.data(), static_cast<std::size_t>(eta.size())}, 0.5))
    refinements.push_back({cell, {}});
  apply_refinements(rung.forest, solution.discretization.mesh, refinements);
}

StaticSolution solve(LadderRung& rung) {
  rung.problem.solver.linear.relative_residual = 1e-9;  // far below the smallest error here
  FactorCache factors;
  StaticSolution solution = solve_static(rung.forest, rung.problem, nullptr, factors);
  for (int step = 0; step < rung.refinements; ++step) {
    refine(rung, solution);
    solution = solve_static(rung.forest, rung.problem, nullptr, factors);
  }
  if (!solution.equilibrium.converged) throw std::runtime_error(rung.name + ": the solve did not converge");
  return solution;
}

bool has_hanging_corner(const Discretization& d, int cell) {
  return std::ranges::any_of(d.mesh.cells[cell], [&](int node) { return d.hanging.hangs(node); });
}

/// Estimated over true error, whole and by cells.
Effectivity effectivity_of(const Discretization& d, const Eigen::VectorXd& eta, const TrueError& truth) {
  Effectivity result;
  result.global = eta.norm() / truth.total;
  if (truth.cell.size() == 0) return result;
  std::vector<double> by_cell(eta.size());
  double estimated = 0.0, exact = 0.0;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    by_cell[cell] = eta[cell] / truth.cell[cell];
    if (!has_hanging_corner(d, cell)) continue;
    estimated += eta[cell] * eta[cell];
    exact += truth.cell[cell] * truth.cell[cell];
  }
  std::ranges::sort(by_cell);
  result.p5 = percentile(by_cell, 0.05), result.p50 = percentile(by_cell, 0.5), result.p95 = percentile(by_cell, 0.95);
  result.at_front = exact > 0.0 ? std::sqrt(estimated / exact) : 0.0;
  return result;
}

double largest_relative_change(const ErrorEstimate& a, const ErrorEstimate& b, double scale) {
  const double whole = std::abs(b.relative / a.relative - 1.0);
  return std::max(whole, (b.eta / scale - a.eta).cwiseAbs().maxCoeff() / a.eta.maxCoeff());
}

}  // namespace

std::vector<LadderRung> ladder_rungs(bool full) {
  std::vector<LadderRung> rungs;
  rungs.push_back(smooth_rung("smooth, regular", cube({8, 8, 8}), smooth_solution()));
  rungs.push_back(smooth_rung("smooth, perturbed", perturbed_cube(8), smooth_solution()));
  rungs.push_back(smooth_rung("smooth, flat cells 1:1:4", cube({16, 16, 4}), smooth_solution()));
  rungs.push_back(smooth_rung("smooth, octant 2x2x2", cube({8, 8, 8}), smooth_solution()));
  refine_octant(rungs.back(), 8, [](int) { return RefinementTemplate{{2, 2, 2}}; });
  rungs.push_back(smooth_rung("smooth, octant of mixed templates", cube({8, 8, 8}), smooth_solution()));
  const std::array<RefinementTemplate, 3> mixed = {{{{2, 2, 2}}, {{2, 1, 2}}, {{1, 2, 2}}}};
  refine_octant(rungs.back(), 8, [&](int number) { return mixed[static_cast<std::size_t>(number) % mixed.size()]; });
  Material nearly_incompressible;
  nearly_incompressible.poisson_ratio = 0.4999;
  nearly_incompressible.dilatation = Dilatation::mean;
  rungs.push_back(smooth_rung("isochoric, nu 0.4999", cube({8, 8, 8}), isochoric_solution(), nearly_incompressible));
  rungs.push_back(
      smooth_rung("isochoric, nu 0.4999, perturbed", perturbed_cube(8), isochoric_solution(), nearly_incompressible));
  rungs.push_back(notch_rung("notch, opening", CornerMode::opening, 8, 0));
  rungs.push_back(notch_rung("notch, opening, refined", CornerMode::opening, 4, 3));
  rungs.push_back(notch_rung("notch, sliding", CornerMode::sliding, 8, 0));
  rungs.push_back(crack_rung("crack", 8, 0));
  rungs.push_back(crack_rung("crack, refined", 4, 3));
  rungs.push_back(rim_rung("clamped rim", 8, 0, 0.3));
  rungs.push_back(rim_rung("clamped rim, refined", 8, 3, 0.3));
  for (const auto& [nu, text] : {std::pair{0.2, "0.2"}, {0.4, "0.4"}, {0.45, "0.45"}})
    rungs.push_back(rim_rung(std::string("clamped rim, nu ") + text, 8, 0, nu));
  rungs.push_back(notch_rung("notch, opening, nu 0.45", CornerMode::opening, 8, 0, 0.45));
  rungs.push_back(block_rung("clamped block", 6, 0.3, pulled_block_energy));
  rungs.push_back(block_rung("clamped block, nu 0.45", 6, 0.45, 9.27752e-4));
  rungs.push_back(lshape_rung(0));
  rungs.push_back(lshape_rung(3));
  rungs.back().name += ", refined";
  if (full) {
    rungs.push_back(smooth_rung("smooth, regular, n = 16", cube({16, 16, 16}), smooth_solution()));
    rungs.push_back(smooth_rung("smooth, perturbed, n = 16", perturbed_cube(16), smooth_solution()));
    rungs.push_back(notch_rung("notch, opening, n = 16", CornerMode::opening, 16, 0));
    rungs.push_back(rim_rung("clamped rim, n = 16", 16, 0, 0.3));
    rungs.push_back(crack_rung("crack, n = 16", 16, 0));
  }
  return rungs;
}

LadderRow climb(LadderRung& rung) {
  const StaticSolution solution = solve(rung);
  const Discretization& d = solution.discretization;
  const Eigen::Matrix3Xd& u = solution.equilibrium.u;
  LadderRow row;
  row.rung = rung.name;
  row.cells = d.mesh.cell_count(), row.dofs = d.dof_count(), row.hanging_nodes = d.hanging.hanging_count();

  Stopwatch watch;
  const auto per_cell = [&] { return 1e3 * watch.lap() / row.cells; };
  const ErrorEstimate spr = estimate_error(d, u, Estimator::spr);
  const double spr_cost = per_cell();
  const ErrorEstimate edges = estimate_error(d, u, Estimator::spr_edges);
  const double edges_cost = per_cell();
  EquilibratedOptions local;
  local.degree = 2;
  const EquilibratedEstimate equilibrated = estimate_error_equilibrated(rung.forest, d, rung.problem, u, spr, local);
  const double equilibrated_cost = per_cell();
  if (!equilibrated.exists()) throw std::runtime_error(rung.name + ": " + equilibrated.why_not);

  TrueError truth;
  if (rung.exact.stress) {
    truth = true_error(d, rung.exact, u, spr.nodal_stress);
    row.true_error = truth.total / truth.energy_norm;
  } else {
    // Of all displacements that the mesh allows the solution has the least energy, all loads given: ‖e‖² is what the
    // exact solution's work lacks.
    truth.total = std::sqrt(rung.exact_energy - spr.energy_norm * spr.energy_norm);
    row.true_error = truth.total / std::sqrt(rung.exact_energy);
  }
  row.of["spr"] = effectivity_of(d, spr.eta, truth);
  row.of["spr_edges"] = effectivity_of(d, edges.eta, truth);
  row.of["equilibrated"] = effectivity_of(d, equilibrated.eta, truth);
  row.of["spr"].microseconds_per_cell = spr_cost;
  row.of["spr_edges"].microseconds_per_cell = edges_cost;
  row.of["equilibrated"].microseconds_per_cell = equilibrated_cost;
  return row;
}

double largest_change_under_rotation() {
  // A bar that is bent and pulled, refined at its clamp; then the same state turned as a whole.
  Material material;
  material.kinematics = Kinematics::corotational;
  RefinementForest forest(box_mesh(box(Eigen::Vector3d::Zero(), {3.0, 1.0, 1.0}, {6, 2, 2})));
  forest.refine(0, {{2, 2, 2}});
  const Discretization d = discretize(forest, material, {{"x_min", std::nullopt, {}}});
  Eigen::Matrix3Xd u(3, d.mesh.node_count());
  for (Eigen::Index node = 0; node < u.cols(); ++node) {
    const Eigen::Vector3d X = d.mesh.nodes.col(node);
    u.col(node) = Eigen::Vector3d(0.02 * X.x() - 0.03 * X.x() * X.y(), 0.05 * X.x() * X.x(), 0.01 * X.y() * X.z());
  }
  u = expand(d.hanging, gather(d.hanging, u));
  const ErrorEstimate rest = estimate_error(d, u, Estimator::spr_edges);
  double largest = 0.0;
  for (const double degrees : {10.0, 45.0, 90.0, 135.0, 179.0, 180.0}) {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(degrees * pi / 180.0, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
    const Eigen::Matrix3Xd turned = R * (d.mesh.nodes + u) - d.mesh.nodes;
    largest = std::max(largest, largest_relative_change(rest, estimate_error(d, turned, Estimator::spr_edges), 1.0));
  }
  return largest;
}

double largest_change_under_units() {
  // Lengths in millimetres, forces in newtons, stresses in megapascals: energies are a thousand times as many.
  const auto in_units = [](double length, double stress) {
    Material material;
    material.youngs_modulus = 1e3 * stress;
    BoxMeshOptions options = box(Eigen::Vector3d::Zero(), length * Eigen::Vector3d(4.0, 4.0, 2.0), {4, 4, 2});
    options.removed = RemovedBlock{{2, 0, 0}, {4, 2, 2}};
    StaticProblem problem;
    problem.material = material;
    problem.supports.push_back({"x_max", std::nullopt, {}});
    problem.loads.push_back({"x_min", LoadKind::traction, {-stress, 0.0, 0.0}});
    problem.estimator = Estimator::spr_edges;
    problem.solver.linear.relative_residual = 1e-13;
    FactorCache factors;
    return solve_static(RefinementForest(box_mesh(options)), problem, nullptr, factors).estimate;
  };
  return largest_relative_change(in_units(1.0, 1.0), in_units(1e3, 1e-6), std::sqrt(1e3 * 1e3 * 1e3 * 1e-6));
}

Evidence estimator_ladder_evidence(const EvidenceOptions& options) {
  std::vector<LadderRung> rungs = ladder_rungs(options.full);
  Evidence evidence;
  EvidenceTable global{"Effectivity: estimated over true error in the energy norm",
                       {"rung", "cells", "hanging", "true error", "spr", "spr_edges", "equilibrated"},
                       {}};
  EvidenceTable by_cell{"Effectivity over cells: p5, p50, p95 of spr_edges, of equilibrated; at hanging corners",
                        {"rung", "p5", "p50", "p95", "p5", "p50", "p95", "front, spr_edges"},
                        {}};
  std::map<std::string, double> time;
  double cells = 0.0;
  const EffectivityRange range = *effectivity_range(ProblemKind::hexahedra);
  for (std::size_t k = 0; k < rungs.size(); ++k) {
    if (options.interrupted()) return evidence;
    options.progress(static_cast<double>(k) / static_cast<double>(rungs.size()), rungs[k].name);
    const LadderRow row = climb(rungs[k]);
    const Effectivity &spr = row.of.at("spr"), &edges = row.of.at("spr_edges"), &bound = row.of.at("equilibrated");
    global.rows.push_back({row.rung, static_cast<double>(row.cells), static_cast<double>(row.hanging_nodes),
                           row.true_error, spr.global, edges.global, bound.global});
    by_cell.rows.push_back({row.rung, edges.p5, edges.p50, edges.p95, bound.p5, bound.p50, bound.p95, edges.at_front});
    cells += row.cells;
    for (const char* name : estimators) time[name] += row.cells * row.of.at(name).microseconds_per_cell;

    std::string key = row.rung;
    std::ranges::replace(key, ' ', '_');
    std::erase(key, ',');
    evidence.claim("hexahedra." + key, edges.global, range.low, range.high,
                   "what scenes print as the range of their error rests on it");
    evidence.claim("equilibrated." + key, bound.global, 1.0, 2.0,
                   "a stress in equilibrium is as far from the solution as the exact one or farther");
    if (rungs[k].singular && rungs[k].refinements == 0)
      evidence.claim("spr." + key, spr.global, 0.6, 0.9,
                     "no polynomial follows an unbounded stress; else the weights would be for nothing");
    if (rungs[k].has_front)
      evidence.claim("front." + key, edges.at_front / edges.global, 0.85, 1.15,
                     "the estimate does not light up along hanging nodes");
  }
  EvidenceTable cost{"Cost", {"estimator", "us per cell", "over spr"}, {}};
  for (const char* name : estimators)
    cost.rows.push_back({std::string(name), time[name] / cells, time[name] / time["spr"]});
  evidence.tables = {global, by_cell, cost};
  add_kinds(options, evidence);
  evidence.claim("change_under_rotation", largest_change_under_rotation(), 0.0, 1e-10,
                 "stresses are compared in one frame that turns with the body");
  evidence.claim("change_under_units", largest_change_under_units(), 0.0, 1e-10,
                 "nothing dimensionless knows of metres; the solver stops at 1e-13");
  return evidence;
}

}  // namespace finegauge
