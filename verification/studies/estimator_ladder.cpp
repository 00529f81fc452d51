#include "verification/studies/estimator_ladder.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/equilibrated_estimate.hpp"
#include "core/stopwatch.hpp"
#include "verification/studies/estimator_kinds.hpp"
#include "verification/studies/problem_parts.hpp"
#include "verification/support/percentile.hpp"

namespace finegauge {

namespace {

using std::numbers::pi;
constexpr std::array<const char*, 3> estimators = {"spr", "spr_edges", "equilibrated"};

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

  const TrueError truth = true_error_of(rung, solution, spr);
  row.true_error = truth.total / truth.energy_norm;
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
  RefinementForest forest(block({3.0, 1.0, 1.0}, {6, 2, 2}));
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
    StaticProblem problem;
    problem.material = material;
    problem.supports.push_back({"x_max", std::nullopt, {}});
    problem.loads.push_back({"x_min", LoadKind::traction, {-stress, 0.0, 0.0}});
    problem.estimator = Estimator::spr_edges;
    problem.solver.linear.relative_residual = 1e-13;
    FactorCache factors;
    return solve_static(
               RefinementForest(block(length * Eigen::Vector3d(4.0, 4.0, 2.0), {4, 4, 2}, {{2, 0, 0}, {4, 2, 2}})),
               problem, nullptr, factors)
        .estimate;
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
