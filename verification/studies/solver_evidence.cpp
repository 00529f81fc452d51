#include "verification/studies/solver_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/solve/direct_solver.hpp"
#include "verification/studies/augmented_lagrangian.hpp"
#include "verification/studies/dynamics.hpp"
#include "verification/support/convergence.hpp"

namespace finegauge {

namespace {

/// Refined towards an edge of the box that is loaded and not held, `levels` times.
RefinementForest graded_box(int levels) {
  BoxMeshOptions options;
  options.cells = {4, 4, 4};
  RefinementForest forest(box_mesh(options));
  for (int level = 0; level < levels; ++level) {
    const Mesh mesh = forest.leaf_mesh();
    for (int cell = 0; cell < mesh.cell_count(); ++cell) {
      bool touches = false;
      for (const int corner : mesh.cells[cell]) {
        const auto X = mesh.nodes.col(corner);
        touches = touches || (X.x() > 1.0 - 1e-9 && X.z() > 1.0 - 1e-9);
      }
      if (touches) forest.refine(mesh.forest_cell[cell], {{2, 2, 2}});
    }
  }
  return forest;
}

/// Largest eigenvalue of a symmetric positive operator on free directions, from below.
template <class Operator>
double largest_eigenvalue(const Supports& supports, Eigen::Index n, const Operator& apply) {
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = std::cos(1.7 * static_cast<double>(i));  // of no symmetry
  project(supports, x);
  double value = 0.0;
  for (int step = 0; step < 200; ++step) {
    x.normalize();
    const Eigen::VectorXd y = apply(x);
    value = x.dot(y);
    x = y;
    project(supports, x);
  }
  return value;
}

NeedleInBox contact_box(AxialLaw axial, LateralLaw lateral) {
  NeedleInBoxOptions options;
  options.refine = true;  // points about a cell apart: closer rows are nearly dependent, and every weight is slow
  options.points = 4;
  options.axial = axial;
  options.lateral = lateral;
  return needle_in_box(options);
}

void show_error_factors(Evidence& evidence) {
  EvidenceTable table{
      "Uzawa's iteration with bilateral rows of weight kappa: factor of the error per iteration",
      {"kappa", "1 / (1 + w sigma_min)", "from the slowest error", "from none", "condition of A + J'WJ"},
      {}};
  const auto rows =
      error_factors(contact_box(AxialLaw::bilateral, LateralLaw::bilateral), {1e-1, 1e0, 1e1, 1e2, 1e3, 1e4});
  double attained = 0.0, above = 0.0, growth = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const ErrorFactorRow& row = rows[k];
    table.rows.push_back({row.kappa, row.bound, row.slowest, row.generic, row.condition});
    attained = std::max(attained, std::abs(row.slowest / row.bound - 1.0));
    above = std::max(above, row.generic / row.bound);
    if (k >= 4) growth = std::max(growth, std::abs(row.condition / rows[k - 1].condition / 10.0 - 1.0));
  }
  evidence.tables.push_back(std::move(table));
  evidence.claim("uzawa_bound_attained", attained, 0.0, 1e-6,
                 "theory, from an error along the slowest eigenvector; the dense solution is good to 1e-12");
  evidence.claim("uzawa_bound_kept", above, 1e-3, 1.0 + 1e-6, "theory, from zero");
  evidence.claim("uzawa_factor_range_first", rows.front().bound, 0.9, 1.0, "weights from slow");
  evidence.claim("uzawa_factor_range_last", rows.back().bound, 0.0, 0.1, "to fast");
  evidence.claim("uzawa_condition_growth", growth, 0.0, 0.1, "once the rows dominate it grows as the weight");
}

void show_weights(Evidence& evidence, bool full) {
  EvidenceTable table{"The contact's forces against a dense solution with the same active set, by weight",
                      {"law", "kappa", "converged", "iterations", "force error", "violation"},
                      {}};
  struct Law {
    const char* name;
    AxialLaw axial;
    LateralLaw lateral;
  };
  std::vector<double> kappas;
  for (double kappa = 1e1; kappa < 2e17; kappa *= full ? 10.0 : 1e2) kappas.push_back(kappa);
  for (const Law& law : {Law{"bilateral", AxialLaw::bilateral, LateralLaw::bilateral},
                         Law{"friction", AxialLaw::friction, LateralLaw::bilateral},
                         Law{"surface", AxialLaw::unilateral, LateralLaw::coulomb}}) {
    const WeightTable weights = weight_table(contact_box(law.axial, law.lateral), kappas);
    double error = 0.0;
    int unconverged = 0;
    for (const WeightRow& row : weights.rows) {
      table.rows.push_back(
          {law.name, row.kappa, row.converged ? "yes" : "no", double(row.iterations), row.force_error, row.violation});
      error = std::max(error, row.force_error);
      unconverged += !row.converged;
    }
    const std::string name = std::string("weights_") + law.name;
    evidence.claim(name + "_force_error", error, 0.0, 1e-6,
                   "tolerance 1e-8 of the change of the forces, times what an iteration may leave over");
    evidence.claim(name + "_unconverged", unconverged, 0.0, 0.0, "from 10 to 1e17, sixteen decades");
  }
  evidence.tables.push_back(std::move(table));
}

void show_ladder(Evidence& evidence, bool full) {
  std::vector<double> asked;
  for (double residual = 1e-2; residual > 0.9e-12; residual /= full ? 10.0 : 100.0) asked.push_back(residual);
  const AlgebraicLadder ladder = algebraic_ladder(asked);
  EvidenceTable table{
      "A static solve by multigrid on a mesh with " + std::to_string(ladder.hanging_nodes) + " hanging nodes, " +
          std::to_string(ladder.dofs) + " dofs, against the direct solution",
      {"residual asked", "iterations", "reported", "recomputed", "error in the energy norm", "defect of the energy"},
      {}};
  double reported = 0.0, least = std::numeric_limits<double>::infinity(), most = 0.0, square = 0.0, kept = 0.0,
         beyond = 0.0;
  int most_iterations = 0;
  ErrorSeries series{"energy norm", {}, {}};
  for (const AlgebraicRow& row : ladder.rows) {
    table.rows.push_back(
        {row.asked, double(row.iterations), row.reported, row.true_residual, row.energy_norm, row.energy_defect});
    reported = std::max(reported, std::abs(row.reported - row.true_residual));
    kept = std::max(kept, row.reported / row.asked);
    const double ratio = row.energy_norm / row.reported;
    least = std::min(least, ratio);
    most = std::max(most, ratio);
    beyond = std::max(beyond, row.energy_norm / row.asked);
    if (row.energy_norm > 1e-6)
      square = std::max(square, std::abs(row.energy_defect / (row.energy_norm * row.energy_norm) - 1.0));
    most_iterations = std::max(most_iterations, row.iterations);
    series.h.push_back(row.asked);
    series.error.push_back(row.energy_norm);
  }
  evidence.tables.push_back(std::move(table));
  const double root = std::sqrt(ladder.condition);
  evidence.claim("ladder_hanging_nodes", ladder.hanging_nodes, 50.0, 1e4, "the mesh has some");
  evidence.claim("ladder_meshes_below", ladder.levels, 1.0, 10.0, "there is a coarser mesh, so that it is multigrid");
  evidence.claim("ladder_residual_over_asked", kept, 1e-3, 1.0, "what was asked for, or better");
  evidence.claim("ladder_reported_residual_error", reported / ladder.round_off, 0.0, 1.0,
                 "what is reported is the residual of the cells' forces, but for the round-off of their positions");
  evidence.claim("ladder_least_error_over_residual", least, 1.0 / root, root,
                 "the energy norm of an error is residual / sqrt(condition) at least");
  evidence.claim("ladder_most_error_over_residual", most, 1.0 / root, root,
                 "and residual times sqrt(condition) at most: |r|^2 / highest <= r'A^-1 r <= |r|^2 / lowest");
  evidence.claim(
      "ladder_most_error_over_asked", beyond, 0.0, 1.0,
      "of a load on a surface, smoother than what a cycle leaves: r is stiffer than b, and its error smaller");
  evidence.claim("ladder_error_order_in_residual", fitted_order(series), 0.85, 1.15,
                 "a residual ten times smaller is an error ten times smaller");
  evidence.claim("ladder_energy_defect_over_square", square, 0.0, 1e-3,
                 "2 f'u - u'Ku misses the energy by the square of the error, where that is above round-off");
  evidence.claim("ladder_most_iterations", most_iterations, 8.0, 20.0, "twelve decades at a factor of 0.25 a cycle");
}

void show_oscillator(Evidence& evidence) {
  EvidenceTable table{"An eigenmode on a hanging mesh by backward Euler, per step",
                      {"omega tau", "mode", "amplitude", "1 / sqrt(1 + (wt)^2)", "energy", "1 / (1 + (wt)^2)",
                       "phase [rad]", "atan(wt)", "error of the path", "other modes"},
                      {}};
  double rates = 0.0, printed_error = 0.0, path = 0.0;
  int hanging = 0;
  for (const double wt : {0.1, 1.0, 10.0})
    for (const int mode : {0, 3}) {
      OscillatorCase the_case;
      the_case.mode = mode;
      the_case.omega_tau = wt;
      the_case.steps = wt > 1.0 ? 3 : 20;  // round-off stays below 1e-10 of what is left
      const OscillatorRow row = run_oscillator(the_case);
      const double amplitude = 1.0 / std::sqrt(1.0 + wt * wt), energy = 1.0 / (1.0 + wt * wt);
      table.rows.push_back({wt, double(mode), row.amplitude_factor, amplitude, row.energy_ratio, energy, row.phase,
                            std::atan(wt), row.largest_error, row.other_modes});
      rates = std::max({rates, std::abs(row.amplitude_factor - amplitude), std::abs(row.energy_ratio - energy),
                        std::abs(row.phase - std::atan(wt))});
      const double printed = wt < 0.5 ? 0.995037190 : wt < 5.0 ? 0.707106781 : 0.099503719;
      printed_error = std::max(printed_error, std::abs(row.amplitude_factor - printed));
      path = std::max({path, row.largest_error, row.other_modes});
      hanging = row.hanging_nodes;
    }
  evidence.tables.push_back(std::move(table));
  evidence.claim("oscillator_hanging_nodes", hanging, 1.0, 1e3, "the mode lives on a mesh with hanging nodes");
  evidence.claim("oscillator_rates_error", rates, 0.0, 1e-10, "closed forms; round-off of some 20 steps");
  evidence.claim("oscillator_printed_digits", printed_error, 0.0, 1e-9,
                 "nine decimals written out, so that formula and code are not wrong together");
  evidence.claim("oscillator_path_error", path, 0.0, 1e-11, "the discrete closed form, step by step; round-off");

  const ErrorSeries series = oscillator_temporal_errors(200, 4);
  EvidenceTable times{"Displacement after 1.3 periods against the cosine", {"tau [s]", "relative error"}, {}};
  for (std::size_t k = 0; k < series.h.size(); ++k) times.rows.push_back({series.h[k], series.error[k]});
  evidence.tables.push_back(std::move(times));
  evidence.claim("oscillator_order_last", last_order(series), 0.95, 1.05, "backward Euler is of first order");
  evidence.claim("oscillator_order_fitted", fitted_order(series), 0.95, 1.05, "the same over all grids");
  constexpr double angle = 2.6 * std::numbers::pi;
  // q⁺ = q / (1 ∓ i ωτ): the amplitude falls by exp(-ωτ ωT / 2), the phase is right to (ωτ)².
  evidence.claim("oscillator_error_over_theory",
                 series.error.back() / (0.5 * angle * angle / 1600.0 * std::abs(std::cos(angle))), 0.9, 1.1,
                 "the constant: omega^2 tau T |cos(omega T)| / 2, less its square");
}

void show_energy(Evidence& evidence, bool full) {
  const int steps = full ? 10000 : 2000;
  EvidenceTable table{std::to_string(steps) + " steps without load from random displacements and velocities",
                      {"kinematics", "tau [s]", "largest growth in a step", "all growth", "energy left",
                       "momentum drift", "angular drift"},
                      {}};
  const auto show = [&](const EnergyRow& row) {
    const bool clamped = row.kinematics == Kinematics::linear;
    const auto drift = [&](double value) { return clamped ? TableValue("clamped") : TableValue(value); };
    table.rows.push_back({clamped ? "linear" : "corotational", row.tau, row.largest_growth, row.summed_growth,
                          row.final_energy, drift(row.momentum_drift), drift(row.angular_drift)});
  };
  const EnergyRow linear = run_unloaded_motion(Kinematics::linear, 1e-3, steps);
  show(linear);
  std::vector<EnergyRow> free;
  for (const double tau : {0.04, 0.02, 0.01})
    show(free.emplace_back(run_unloaded_motion(Kinematics::corotational, tau, steps)));
  evidence.tables.push_back(std::move(table));
  evidence.claim("energy_linear_largest_growth", linear.largest_growth, -1.0, -1e-12,
                 "backward Euler takes (omega tau)^2 of every mode's energy in every step; far above round-off");
  evidence.claim("energy_linear_left", linear.final_energy, 1e-3, 0.9, "there was some to gain from");
  double momentum = 0.0, left = 0.0, summed = 0.0;
  for (const EnergyRow& row : free) {
    momentum = std::max(momentum, row.momentum_drift);
    left = std::max(left, row.final_energy);
    summed = std::max(summed, row.summed_growth);
  }
  evidence.claim("energy_momentum_drift", momentum, 0.0, 1e-11,
                 "a free body: internal forces sum to zero; round-off of all steps");
  evidence.claim("energy_corotational_left", left, 0.0, 1.0 - 1e-6, "over all steps it falls");
  // From here on no bound is known to us that does not come from a measurement.
  const std::string measured = "no independent bound is known to us: three times what was measured, ";
  evidence.claim("energy_corotational_growth_at_40_ms", free[0].largest_growth, 0.0, 3.0 * 2.9e-4,
                 measured + "2.9e-4 of the start; frozen rotations are no gradient of an energy");
  evidence.claim("energy_corotational_growth_at_20_ms", free[1].largest_growth, 0.0, 3.0 * 9.8e-5, measured + "9.8e-5");
  evidence.claim("energy_corotational_growth_at_10_ms", free[2].largest_growth, 0.0, 3.0 * 1.8e-5, measured + "1.8e-5");
  evidence.claim("energy_corotational_all_growth", summed, 0.0, 3e-3, measured + "9e-4");
  evidence.claim(
      "energy_angular_drift_ratio", free[2].angular_drift / free[0].angular_drift, 0.0, 0.25,
      "angular momentum is not kept, but with steps four times shorter at least as much better: first order");
}

}  // namespace

AlgebraicLadder algebraic_ladder(const std::vector<double>& asked) {
  const RefinementForest forest = graded_box(3);
  Material material;
  material.youngs_modulus = 1e4;
  material.poisson_ratio = 0.3;
  material.dilatation = Dilatation::mean;
  const std::vector<SupportCondition> clamped = {{"x_min", {}, {}}};
  const Discretization d = discretize(forest, material, clamped);
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, clamped, {50, 0.9});
  const Eigen::Matrix3Xd loads =
      nodal_loads(forest.base(), d.mesh, {{"x_max", LoadKind::traction, Eigen::Vector3d(0.5, 1.0, -2.0)}});
  const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());

  BlockMatrix<double> A = assemble_stiffness(d, rest);
  apply_supports(d.supports, A);
  Eigen::VectorXd b = reduce_forces(d.hanging, loads);
  project(d.supports, b);
  const DirectSolver direct(A);
  if (!direct.factored()) throw std::runtime_error("algebraic ladder: the stiffness could not be factored");
  Eigen::VectorXd product, exact = direct.solve(b);
  multiply(A, exact, product);
  exact += direct.solve(b - product);
  multiply(A, exact, product);
  const double energy = exact.dot(product);
  const double unit = std::numeric_limits<double>::epsilon() / 2.0;

  AlgebraicLadder ladder;
  ladder.dofs = d.dof_count();
  ladder.hanging_nodes = d.hanging.hanging_count();
  ladder.levels = static_cast<int>(hierarchy.coarse.size());
  const double highest = largest_eigenvalue(d.supports, b.size(), [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd y;
    multiply(A, x, y);
    return y;
  });
  const double lowest =
      1.0 / largest_eigenvalue(d.supports, b.size(), [&](const Eigen::VectorXd& x) { return direct.solve(x); });
  ladder.condition = highest / lowest;
  ladder.round_off = unit * (to_sparse(A).cwiseAbs() * gather(d.hanging, d.mesh.nodes)).norm() / b.norm();
  for (const double residual : asked) {
    EquilibriumOptions options;
    options.method = LinearMethod::multigrid;
    options.linear = {residual, 500};
    const Equilibrium found = solve_equilibrium(d, hierarchy, loads, rest, options);
    if (!found.converged) throw std::runtime_error("algebraic ladder: multigrid did not converge");
    const Eigen::VectorXd x = gather(d.hanging, found.u), error = x - exact;
    AlgebraicRow row;
    row.asked = residual;
    row.iterations = found.linear_iterations;
    row.reported = found.relative_residual;
    // Cell by cell, without the matrix that was solved with.
    Eigen::VectorXd rest_force = reduce_forces(d.hanging, loads - internal_forces(d, found.u));
    project(d.supports, rest_force);
    row.true_residual = rest_force.norm() / b.norm();
    multiply(A, error, product);
    row.energy_norm = std::sqrt(std::max(0.0, error.dot(product)) / energy);
    row.energy_defect = 1.0 - found.energy / energy;
    ladder.rows.push_back(row);
  }
  return ladder;
}

Evidence solver_evidence(const EvidenceOptions& options) {
  static constexpr EvidencePart parts[] = {
      {"Uzawa's error factor", [](Evidence& e, bool) { show_error_factors(e); }},
      {"weights of the augmented Lagrangian", show_weights},
      {"residual and error of a static solve", show_ladder},
      {"the oscillator of backward Euler", [](Evidence& e, bool) { show_oscillator(e); }},
      {"energy and momentum", show_energy},
  };
  return show_parts(parts, options);
}

}  // namespace finegauge
