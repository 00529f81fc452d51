#include "core/equilibrium.hpp"

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>

#include "core/solve/direct_solver.hpp"

namespace finegauge {
namespace {

class Stopwatch {
 public:
  /// Milliseconds since the last lap.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Solves A x = b with the method that the options ask for; x starts at zero.
SolveReport solve_linear(const Discretization& d, const MeshHierarchy& hierarchy, const BlockMatrix<double>& A,
                         const Eigen::Matrix3Xd& u, const Eigen::VectorXd& b, const EquilibriumOptions& options,
                         const IterationLimits& limits, Eigen::VectorXd& x) {
  x.setZero(b.size());
  if (choose_method(d, hierarchy, options.method) == LinearMethod::direct) {
    const DirectSolver solver(A);
    SolveReport report;
    if (!solver.factored()) {
      report.relative_residual = 1.0;
      return report;
    }
    x = solver.solve(b);
    Eigen::VectorXd Ax;
    multiply(A, x, Ax);
    const double norm = b.norm();
    report.relative_residual = norm > 0.0 ? (b - Ax).norm() / norm : 0.0;
    report.converged = report.relative_residual <= std::max(limits.relative_residual, 1e-9);
    report.iterations = 1;
    return report;
  }
  Multigrid multigrid(d, A, u, hierarchy);
  if (!multigrid.usable()) {
    SolveReport report;
    report.relative_residual = 1.0;
    return report;
  }
  return conjugate_gradients(
      A, b, [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) { multigrid.apply(r, z); }, limits, x);
}

/// Out-of-balance force in the free directions.
Eigen::VectorXd free_residual(const Discretization& d, const Eigen::VectorXd& loads, const Eigen::VectorXd& internal) {
  Eigen::VectorXd r = loads - internal;
  project(d.supports, r);
  return r;
}

/// What residuals are compared with: the loads and the forces that the prescribed displacements alone would cause.
double force_scale(const Discretization& d, const Eigen::VectorXd& loads, const Eigen::VectorXd& internal) {
  Eigen::VectorXd free_loads = loads;
  project(d.supports, free_loads);
  return std::max(free_loads.norm(), internal.norm());
}

Equilibrium solve_linear_equilibrium(const Discretization& d, const MeshHierarchy& hierarchy,
                                     const Eigen::VectorXd& loads, const Eigen::Matrix3Xd& start,
                                     const EquilibriumOptions& options) {
  Equilibrium result;
  Stopwatch watch;
  BlockMatrix<double> A;
  A.reset(d.pattern);
  assemble_regular_cells(d, start, A);
  result.times.assemble_ms = watch.lap();
  assemble_hanging_cells(d, start, A);
  result.times.reduce_ms = watch.lap();

  Eigen::VectorXd x = gather(d.hanging, start);
  impose(d.supports, x);
  Eigen::VectorXd Ax, prescribed = Eigen::VectorXd::Zero(x.size());
  impose(d.supports, prescribed);
  multiply(A, prescribed, Ax);
  Eigen::VectorXd reference = loads - Ax;
  project(d.supports, reference);
  multiply(A, x, Ax);
  const Eigen::VectorXd r = free_residual(d, loads, Ax);
  apply_supports(d.supports, A);

  // The start solves part of the problem: the rest needs to be solved only to the residual that the whole one asks for.
  const double scale = reference.norm(), rest = r.norm();
  IterationLimits limits = options.linear;
  if (rest > 0.0) limits.relative_residual = std::min(1.0, limits.relative_residual * scale / rest);
  Eigen::VectorXd change;
  const SolveReport report = solve_linear(d, hierarchy, A, start, r, options, limits, change);
  x += change;
  result.u = expand(d.hanging, x);
  result.linear_iterations = report.iterations;
  result.newton_iterations = 1;
  result.converged = report.converged && x.allFinite();
  result.relative_residual = scale > 0.0 ? report.relative_residual * rest / scale : 0.0;
  // A now has held directions decoupled; x has no part there but the prescribed one, whose energy is not in A x.
  result.times.solve_ms = watch.lap();
  if (prescribed.isZero(0.0)) {
    // 2 fᵀx - xᵀAx: off by the square of the algebraic error only.
    multiply(A, x, Ax);
    result.energy = 2.0 * loads.dot(x) - x.dot(Ax);
  } else {
    result.energy = strain_energy_product(d, result.u);
  }
  return result;
}

Equilibrium solve_corotational_equilibrium(const Discretization& d, const MeshHierarchy& hierarchy,
                                           const Eigen::VectorXd& loads, const Eigen::Matrix3Xd& start,
                                           const EquilibriumOptions& options) {
  Equilibrium result;
  Eigen::VectorXd x = gather(d.hanging, start);
  impose(d.supports, x);
  result.u = expand(d.hanging, x);
  Stopwatch watch;
  Eigen::VectorXd internal = reduce_forces(d.hanging, internal_forces(d, result.u));
  Eigen::VectorXd r = free_residual(d, loads, internal);
  double scale = force_scale(d, loads, internal);
  for (;;) {
    const double norm = r.norm();
    result.relative_residual = scale > 0.0 ? norm / scale : 0.0;
    if (!std::isfinite(result.relative_residual)) break;
    if (result.relative_residual <= options.newton_residual) {
      result.converged = true;
      break;
    }
    if (result.newton_iterations >= options.newton_iterations) break;
    watch.lap();
    BlockMatrix<double> A;
    A.reset(d.pattern);
    assemble_regular_cells(d, result.u, A);
    result.times.assemble_ms += watch.lap();
    assemble_hanging_cells(d, result.u, A);
    result.times.reduce_ms += watch.lap();
    apply_supports(d.supports, A);
    Eigen::VectorXd change;
    const SolveReport report = solve_linear(d, hierarchy, A, result.u, r, options, options.linear, change);
    result.linear_iterations += report.iterations;
    ++result.newton_iterations;
    if (!report.converged || !change.allFinite()) break;
    // Halve the step until the residual falls; the last resort of a sixteenth is refused, not taken.
    bool accepted = false;
    for (double step = 1.0; step > 1.0 / 64.0; step *= 0.5) {
      const Eigen::VectorXd trial = x + step * change;
      const Eigen::Matrix3Xd u = expand(d.hanging, trial);
      internal = reduce_forces(d.hanging, internal_forces(d, u));
      Eigen::VectorXd trial_r = free_residual(d, loads, internal);
      if (trial_r.norm() < (1.0 - 0.1 * step) * norm) {
        x = trial;
        r = std::move(trial_r);
        result.u = u;
        accepted = true;
        break;
      }
    }
    result.times.solve_ms += watch.lap();
    if (!accepted) break;
    scale = force_scale(d, loads, internal);
  }
  result.energy = strain_energy_product(d, result.u);
  return result;
}

}  // namespace

LinearMethod choose_method(const Discretization& d, const MeshHierarchy& hierarchy, LinearMethod asked) {
  if (asked != LinearMethod::automatic) return asked;
  const bool nearly_incompressible = d.shapes.material().poisson_ratio > 0.45;
  return hierarchy.coarse.empty() || nearly_incompressible ? LinearMethod::direct : LinearMethod::multigrid;
}

Equilibrium solve_equilibrium(const Discretization& d, const MeshHierarchy& hierarchy, const Eigen::Matrix3Xd& loads,
                              const Eigen::Matrix3Xd& start, const EquilibriumOptions& options) {
  const Eigen::VectorXd reduced_loads = reduce_forces(d.hanging, loads);
  return d.shapes.material().kinematics == Kinematics::linear
             ? solve_linear_equilibrium(d, hierarchy, reduced_loads, start, options)
             : solve_corotational_equilibrium(d, hierarchy, reduced_loads, start, options);
}

}  // namespace finegauge
