#include "verification/studies/dynamics.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "verification/support/tissue_samples.hpp"

namespace finegauge {
namespace {

/// Two cells along x, one refined by 2x3x3 so that nodes hang.
RefinementForest two_cell_bar(double length) {
  BoxMeshOptions box;
  box.cells = {2, 1, 1};
  box.size = {length, 0.5 * length, 0.5 * length};
  RefinementForest forest(box_mesh(box));
  forest.refine(1, {{2, 3, 3}});
  return forest;
}

struct Mode {
  double omega;           // [rad/s]
  Eigen::VectorXd shape;  // reduced, φᵀ M φ = 1
};

/// Eigenmodes of the free directions; supports hold whole nodes.
Mode eigenmode(const TissueMesh& mesh, int which) {
  const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, mesh.d.mesh.node_count());
  const Eigen::MatrixXd K = to_sparse(assemble_stiffness(mesh.d, zero)).toDense();
  std::vector<int> free;
  for (int i = 0, s = 0; i < mesh.d.hanging.reduced_count(); ++i) {
    if (s < static_cast<int>(mesh.d.supports.reduced.size()) && mesh.d.supports.reduced[s] == i) {
      ++s;
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) free.push_back(3 * i + axis);
  }
  Eigen::VectorXd root(free.size());
  for (std::size_t k = 0; k < free.size(); ++k) root[k] = std::sqrt(mesh.mass[free[k] / 3]);
  const Eigen::MatrixXd K_free = K(free, free);
  const Eigen::MatrixXd scaled = root.cwiseInverse().asDiagonal() * K_free * root.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  Mode mode{std::sqrt(solver.eigenvalues()[which]), Eigen::VectorXd::Zero(mesh.d.dof_count())};
  for (std::size_t k = 0; k < free.size(); ++k) mode.shape[free[k]] = solver.eigenvectors()(k, which) / root[k];
  return mode;
}

TissueProblem bar_problem() {
  TissueProblem problem;
  problem.material.youngs_modulus = 1e4;
  problem.supports = {{"x_min", std::nullopt, {}}};
  return problem;
}

/// One or more linear steps; throws where a solve fails.
void advance(const TissueMesh& mesh, const TissueProblem& problem, double time, double tau, FactorCache& factors,
             TissueSystem& system, TissueState& state) {
  const TissueStepReport report =
      step_tissue(mesh, problem, time, tau, {}, direct_linear_solve(factors), system, state);
  if (!report.converged) throw std::runtime_error("a step did not converge");
}

template <class... Values>
std::string line(const char* format, Values... values) {
  char text[400];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

const char* name(Kinematics kinematics) { return kinematics == Kinematics::linear ? "linear" : "corotational"; }

}  // namespace

OscillatorRow run_oscillator(const OscillatorCase& the_case) {
  TissueProblem problem = bar_problem();
  const TissueMesh mesh = build_tissue_mesh(two_cell_bar(1.0), problem);
  const Mode mode = eigenmode(mesh, the_case.mode);
  const double w = mode.omega, tau = the_case.omega_tau / w;
  problem.mass_damping = the_case.mass_damping * w;
  problem.stiffness_damping = the_case.stiffness_damping / w;
  OscillatorRow row;
  row.the_case = the_case;
  row.omega = w;
  row.hanging_nodes = mesh.d.hanging.hanging_count();

  // Start with both displacement and speed, so that no term is missing. q: (w u, v) of the mode.
  const double size = 1e-2;
  Eigen::Vector2d q(1.0, 0.4);
  const auto field = [&](double amplitude) { return expand(mesh.d.hanging, amplitude * mode.shape); };
  TissueState state{field(size * q[0] / w), field(size * q[1])};
  const Eigen::Vector2d start = q;
  const double energy = tissue_energy(mesh, state).sum();
  const auto component = [&](const Eigen::Matrix3Xd& nodal) {
    const Eigen::VectorXd reduced = gather(mesh.d.hanging, nodal);
    double sum = 0.0;
    for (Eigen::Index i = 0; i < reduced.size(); ++i) sum += mode.shape[i] * mesh.mass[i / 3] * reduced[i];
    return sum / size;
  };
  // (1 + τ c + (ωτ)²) v⁺ = v - τ ω (ω u), ω u⁺ = ω u + ωτ v⁺.
  const double c = problem.mass_damping + problem.stiffness_damping * w * w;
  const double wt = the_case.omega_tau, D = 1.0 + tau * c + wt * wt;
  Eigen::Matrix2d G;
  G << 1.0 - wt * wt / D, wt / D, -wt / D, 1.0 / D;
  FactorCache factors;
  TissueSystem system;
  Eigen::Vector2d found = q, before = q;
  double turned = 0.0;
  Eigen::Matrix2d pairs_before, pairs_after;  // states 0, 1 and the two last: their map is the step's power
  for (int step = 0; step < the_case.steps; ++step) {
    advance(mesh, problem, step * tau, tau, factors, system, state);
    q = G * q;
    before = found;
    found = {w * component(state.u), component(state.v)};
    row.largest_error = std::max(row.largest_error, (found - q).norm() / start.norm());
    const Eigen::VectorXd rest = gather(mesh.d.hanging, state.u) - size * found[0] / w * mode.shape;
    row.other_modes = std::max(row.other_modes, rest.norm() / (size / w * start.norm() * mode.shape.norm()));
    turned += std::arg(std::complex<double>(found[0], -found[1]) / std::complex<double>(before[0], -before[1]));
  }
  row.phase = turned / the_case.steps;
  row.amplitude_factor = std::pow(found.norm() / start.norm(), 1.0 / the_case.steps);
  row.energy_ratio = std::pow(tissue_energy(mesh, state).sum() / energy, 1.0 / the_case.steps);
  // One more step from another start gives the map itself: columns are states before and after.
  TissueState other{field(size * -0.3 / w), field(size * 1.0)};
  advance(mesh, problem, 0.0, tau, factors, system, other);
  TissueState again{field(size * start[0] / w), field(size * start[1])};
  advance(mesh, problem, 0.0, tau, factors, system, again);
  pairs_before << start[0], -0.3, start[1], 1.0;
  pairs_after << w * component(again.u), w * component(other.u), component(again.v), component(other.v);
  const Eigen::Matrix2d map = pairs_after * pairs_before.inverse();
  const std::complex<double> half_trace = 0.5 * map.trace();
  const std::complex<double> lambda = half_trace + std::sqrt(half_trace * half_trace - map.determinant());
  const std::complex<double> exponent = std::log(lambda);  // (-ζ ± i sqrt(1 - ζ²)) ω τ
  row.damping_ratio = -exponent.real() / std::abs(exponent);
  return row;
}

ErrorSeries oscillator_temporal_errors(int coarsest_steps, int grids) {
  const TissueProblem problem = bar_problem();
  const TissueMesh mesh = build_tissue_mesh(two_cell_bar(1.0), problem);
  const Mode mode = eigenmode(mesh, 0);
  const double T = 1.3 * 2.0 * std::numbers::pi / mode.omega;
  ErrorSeries series{"displacement at T", {}, {}};
  for (int grid = 0, steps = coarsest_steps; grid < grids; ++grid, steps *= 2) {
    const double tau = T / steps;
    TissueState state{expand(mesh.d.hanging, 1e-2 * mode.shape), Eigen::Matrix3Xd::Zero(3, mesh.d.mesh.node_count())};
    FactorCache factors;
    TissueSystem system;
    for (int step = 0; step < steps; ++step) advance(mesh, problem, step * tau, tau, factors, system, state);
    const Eigen::VectorXd exact = 1e-2 * std::cos(mode.omega * T) * mode.shape;
    series.h.push_back(tau);
    series.error.push_back((gather(mesh.d.hanging, state.u) - exact).norm() / (1e-2 * mode.shape).norm());
  }
  return series;
}

EnergyRow run_unloaded_motion(Kinematics kinematics, double tau, int steps) {
  TissueProblem problem = bar_problem();
  problem.material.kinematics = kinematics;
  if (kinematics == Kinematics::corotational) problem.supports.clear();
  const TissueMesh mesh = build_tissue_mesh(two_cell_bar(1.0), problem);
  std::mt19937 generator(7);
  Eigen::VectorXd u = gather(mesh.d.hanging, random_field(mesh.d, 0.01, generator));
  Eigen::VectorXd v = gather(mesh.d.hanging, random_field(mesh.d, 0.1, generator));
  project(mesh.d.supports, u);
  project(mesh.d.supports, v);
  TissueState state{expand(mesh.d.hanging, u), expand(mesh.d.hanging, v)};
  if (kinematics == Kinematics::corotational) {
    // A turn in some two seconds about an oblique axis. In linear tissue it would be a strain that grows, and even a
    // slow turn a displacement without end, in whose round-off a small energy is lost; there the bar is clamped.
    const Eigen::Vector3d spin(1.0, -2.0, 2.0), centre(0.5, 0.25, 0.25);
    for (int node = 0; node < mesh.d.mesh.node_count(); ++node) {
      const Eigen::Vector3d arm = mesh.d.mesh.nodes.col(node) - centre;
      state.v.col(node) += spin.cross(arm);
    }
  }
  EnergyRow row;
  row.kinematics = kinematics;
  row.tau = tau;
  row.steps = steps;
  row.hanging_nodes = mesh.d.hanging.hanging_count();
  const Eigen::Vector3d p = linear_momentum(mesh, state), L = angular_momentum(mesh, state);
  const double start = tissue_energy(mesh, state).sum();
  double energy = start;
  row.largest_growth = -1.0;
  FactorCache factors;
  TissueSystem system;
  for (int step = 0; step < steps; ++step) {
    advance(mesh, problem, step * tau, tau, factors, system, state);
    const double now = tissue_energy(mesh, state).sum(), growth = (now - energy) / start;
    row.largest_growth = std::max(row.largest_growth, growth);
    row.summed_growth += std::max(0.0, growth);
    energy = now;
  }
  row.final_energy = energy / start;
  row.momentum_drift = (linear_momentum(mesh, state) - p).norm() / p.norm();
  row.angular_drift = (angular_momentum(mesh, state) - L).norm() / L.norm();
  return row;
}

std::string energy_table(const std::vector<EnergyRow>& rows) {
  std::string text = "kinematics      tau [s]  steps  largest growth  summed growth  final energy  momentum  angular\n";
  for (const EnergyRow& row : rows)
    text += line("%-13s %9.4g %6d %15.3e %14.3e %13.6g %9.1e %8.1e\n", name(row.kinematics), row.tau, row.steps,
                 row.largest_growth, row.summed_growth, row.final_energy, row.momentum_drift, row.angular_drift);
  return text;
}

Swing run_swing(const std::vector<double>& taus) {
  BoxMeshOptions box;
  box.cells = {8, 2, 2};
  box.size = {0.2, 0.04, 0.04};
  RefinementForest forest(box_mesh(box));
  forest.refine(0, {{2, 2, 2}});
  TissueProblem problem;
  problem.material.youngs_modulus = 2e4;
  problem.material.poisson_ratio = 0.4;
  problem.material.kinematics = Kinematics::corotational;
  problem.gravity = {0.0, -9.81, 0.0};
  problem.supports = {{"x_min", std::nullopt, {}}};
  const TissueMesh mesh = build_tissue_mesh(forest, problem);
  FactorCache factors;
  TissueSystem system;
  TissueState state = state_at_rest(mesh);
  TissueStepOptions newton;
  newton.newton_iterations = 100;
  for (int step = 0; step < 40; ++step)
    if (!step_tissue(mesh, problem, step * 5e-3, 5e-3, newton, direct_linear_solve(factors), system, state).converged)
      throw std::runtime_error("the swing did not converge");
  Swing swing;
  // The end's mid-line, from two nodes of its lower edge's line.
  int tip = -1, inner = -1;
  for (int node = 0; node < mesh.d.mesh.node_count(); ++node) {
    const Eigen::Vector3d X = mesh.d.mesh.nodes.col(node);
    if (X.y() != 0.0 || X.z() != 0.0) continue;
    if (X.x() > 0.199) tip = node;
    if (std::abs(X.x() - 0.175) < 1e-6) inner = node;
  }
  const Eigen::Vector3d end =
      mesh.d.mesh.nodes.col(tip) + state.u.col(tip) - (mesh.d.mesh.nodes.col(inner) + state.u.col(inner));
  swing.end_turned = std::atan2(-end.y(), end.x());
  for (const double tau : taus) {
    SwingRow row;
    row.tau = tau;
    TissueState once = state, many = state;
    row.single_error =
        step_tissue(mesh, problem, 0.0, tau, {}, direct_linear_solve(factors), system, once).equilibrium_error;
    const TissueStepReport report =
        step_tissue(mesh, problem, 0.0, tau, newton, direct_linear_solve(factors), system, many);
    row.newton_iterations = report.newton_iterations;
    row.newton_error = report.equilibrium_error;
    row.converged = report.converged;
    // The same tangent without mixing.
    const Eigen::VectorXd v0 = gather(mesh.d.hanging, state.v);
    Eigen::VectorXd v = gather(mesh.d.hanging, once.v), dv;
    for (int iteration = 2; iteration <= 100 && v.allFinite(); ++iteration) {
      assemble_newton_step(mesh, problem, state, v, 0.0, tau, system);
      (void)direct_linear_solve(factors)(system.A, system.b, dv);
      v += dv + system.prescribed;
      TissueState trial = state;
      update(mesh, v - v0, tau, trial);
      if (!(out_of_balance(mesh, problem, trial, v0, {}, tau).error() <= newton.newton_residual)) continue;
      row.plain_iterations = iteration;
      break;
    }
    swing.rows.push_back(row);
  }
  return swing;
}

std::string swing_table(const Swing& swing) {
  std::string text =
      line("end turned by %.3f rad\n   tau [s]  single error  Newton  error     plain\n", swing.end_turned);
  for (const SwingRow& row : swing.rows)
    text += line("%10.3e %13.4e %7d %9.1e %5d\n", row.tau, row.single_error, row.newton_iterations, row.newton_error,
                 row.plain_iterations);
  return text;
}

}  // namespace finegauge
