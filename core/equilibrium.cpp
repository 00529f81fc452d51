#include "core/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "core/solve/anderson_mixing.hpp"
#include "core/solve/direct_solver.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {
namespace {

/// The factor of the direct method. That of a linear body's base mesh, which has no coarser one, is kept by the cache:
/// multigrid on the finer meshes to come asks for it again. Any other matrix does not return; a copy of it and of its
/// factor would only lie beside the next larger one. Such a factor lives as long as the solve, and the matrices of
/// later iterations, which have its pattern, are factored in its place.
class DirectFactor {
 public:
  const DirectSolver& factor(const Discretization& d, const MeshHierarchy& hierarchy, const BlockMatrix<double>& A,
                             FactorCache& factors) {
    if (hierarchy.coarse.empty() && d.shapes.material().kinematics == Kinematics::linear)
      return *(kept_ = factors.factor(A));
    if (!own_)
      own_.emplace(A);
    else
      static_cast<void>(own_->refactor(A));  // factored() says the same
    return *own_;
  }

 private:
  std::shared_ptr<const DirectSolver> kept_;
  std::optional<DirectSolver> own_;
};

/// Largest change of an edge of a cell over its length under a nodal displacement, of cells that are filled in part
/// times the root of their share, as their energy has it: an upper bound of the strains, turning included.
double largest_strain(const Discretization& d, const Eigen::Matrix3Xd& u) {
  double largest = 0.0;
  const int corners = corner_count(d.mesh.shape);
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const auto& node = d.mesh.cells[cell];
    double square = 0.0;
    for (int a = 0; a < corners; ++a)
      for (int b = a + 1; b < corners; ++b) {
        // Corners of a hexahedron are numbered by a bit an axis: an edge changes one.
        if (d.mesh.shape == CellShape::hexahedron && ((a ^ b) & ((a ^ b) - 1)) != 0) continue;
        square = std::max(square, (u.col(node[a]) - u.col(node[b])).squaredNorm() /
                                      (d.mesh.nodes.col(node[a]) - d.mesh.nodes.col(node[b])).squaredNorm());
      }
    largest = std::max(largest, std::sqrt(material_share(d.mesh, cell) * square));
  }
  return largest;
}

/// sqrt(∫ε:σ / (E V)).
double mean_strain(const Discretization& d, const Eigen::Matrix3Xd& u) {
  double volume = 0.0;
  CellGeometry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell)
    volume += material_share(d.mesh, cell) * d.shapes.geometry(d.mesh, cell, scratch).volume;
  return std::sqrt(strain_energy_product(d, u) / (d.shapes.material().youngs_modulus * volume));
}

/// Solves A x = b with the method that the options ask for; x starts at zero and is added to `displaced` (reduced).
/// `direct` belongs to the mesh.
SolveReport solve_linear(const Discretization& d, const MeshHierarchy& hierarchy, const BlockMatrix<double>& A,
                         const Eigen::Matrix3Xd& u, const Eigen::VectorXd& b, const EquilibriumOptions& options,
                         const IterationLimits& limits, const Eigen::VectorXd& displaced, FactorCache& factors,
                         DirectFactor& direct, Eigen::VectorXd& x) {
  x.setZero(b.size());
  SolveReport not_solved;
  not_solved.relative_residual = 1.0;
  if (choose_method(d, hierarchy, options.method) == LinearMethod::direct) {
    const DirectSolver& solver = direct.factor(d, hierarchy, A, factors);
    return solver.factored() ? solve_refined(solver, A, b, limits.relative_residual, x) : not_solved;
  }
  Multigrid multigrid(d, A, u, hierarchy, factors);
  if (!multigrid.usable()) return not_solved;
  std::optional<double> enough;  // strain; what the body has changes no more where this is asked for
  const auto settled = [&](const Eigen::VectorXd& change) {
    if (!enough)
      enough =
          strain_per_residual * options.linear.relative_residual * mean_strain(d, expand(d.hanging, displaced + x));
    return largest_strain(d, expand(d.hanging, change)) <= *enough;
  };
  return conjugate_gradients(
      A, b, [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) { multigrid.apply(r, z); }, limits, x, settled);
}

/// Out-of-balance force in the free directions.
Eigen::VectorXd free_residual(const Discretization& d, const Eigen::VectorXd& loads, const Eigen::VectorXd& internal) {
  Eigen::VectorXd r = loads - internal;
  project(d.supports, r);
  return r;
}

/// What residuals are compared with: the larger of the loads and of all nodal forces, reactions included.
double force_scale(const Discretization& d, const Eigen::VectorXd& loads, const Eigen::VectorXd& internal) {
  Eigen::VectorXd free_loads = loads;
  project(d.supports, free_loads);
  return std::max(free_loads.norm(), internal.norm());
}

/// Nodal forces [N] that the round-off of the positions alone can cause: a body without stress cannot be told from one
/// with less.
double force_round_off(const Discretization& d, const Eigen::Matrix3Xd& u) {
  const Material& material = d.shapes.material();
  const double extent = (d.mesh.nodes + u).cwiseAbs().maxCoeff();
  const Eigen::Vector3d size = d.mesh.nodes.rowwise().maxCoeff() - d.mesh.nodes.rowwise().minCoeff();
  const double cell_size = std::cbrt(size.prod() / d.mesh.cell_count());
  return std::numeric_limits<double>::epsilon() * (material.bulk() + 2.0 * material.mu()) * cell_size * extent *
         std::sqrt(static_cast<double>(d.dof_count()));
}

Equilibrium solve_linear_equilibrium(const Discretization& d, const MeshHierarchy& hierarchy,
                                     const Eigen::VectorXd& loads, const Eigen::Matrix3Xd& start,
                                     const EquilibriumOptions& options, FactorCache& factors) {
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
  Eigen::VectorXd r = free_residual(d, loads, Ax);
  // A good start may well have the larger residual; one of another problem altogether, which would ask the solver for
  // more digits than there are, is dropped.
  if (!(r.norm() <= 1e6 * reference.norm())) {
    x = prescribed;
    r = reference;
  }
  apply_supports(d.supports, A);

  // The start solves part of the problem: the rest needs to be solved only to the residual that the whole one asks for.
  const double scale = reference.norm(), rest = r.norm();
  IterationLimits limits = options.linear;
  if (rest > 0.0) limits.relative_residual = std::min(1.0, limits.relative_residual * scale / rest);
  Eigen::VectorXd change;
  DirectFactor direct;
  const SolveReport report = solve_linear(d, hierarchy, A, start, r, options, limits, x, factors, direct, change);
  x += change;
  result.u = expand(d.hanging, x);
  result.linear_iterations = report.iterations;
  result.newton_iterations = 1;
  result.converged = report.converged && x.allFinite();
  result.relative_residual = scale > 0.0 ? report.relative_residual * rest / scale : 0.0;
  // A now has held directions decoupled; x has no part there but the prescribed one, whose energy is not in A x.
  result.times.solve_ms = watch.lap();
  if (prescribed.isZero(0.0) && d.springs.empty()) {
    // 2 fᵀx - xᵀAx: off by the square of the algebraic error only.
    multiply(A, x, Ax);
    result.energy = 2.0 * loads.dot(x) - x.dot(Ax);
  } else {
    result.energy = strain_energy_product(d, result.u);
  }
  return result;
}

/// Solving with the rotations of the last iterate is a fixed-point iteration. From rest its first step stretches a
/// bending body so far that residual and energy rise by orders of magnitude before the rotations catch up; a rule that
/// wants them to fall stops right there. Every step is therefore taken whole. Alone the steps crawl or oscillate once
/// stresses turn with the cells (the tangent leaves that out); mixed with the ones before they converge fast.
Equilibrium solve_corotational_equilibrium(const Discretization& d, const MeshHierarchy& hierarchy,
                                           const Eigen::VectorXd& loads, const Eigen::Matrix3Xd& start,
                                           const EquilibriumOptions& options, FactorCache& factors) {
  Equilibrium result;
  Eigen::VectorXd x = gather(d.hanging, start);
  impose(d.supports, x);
  AndersonMixing mixing(mixing_depth);
  DirectFactor direct;
  Stopwatch watch;
  for (;;) {
    result.u = expand(d.hanging, x);
    const Eigen::VectorXd internal = reduce_forces(d.hanging, internal_forces(d, result.u));
    const Eigen::VectorXd r = free_residual(d, loads, internal);
    const double scale = force_scale(d, loads, internal);
    const double norm = r.norm();
    result.relative_residual = scale > 0.0 ? norm / scale : 0.0;
    result.times.solve_ms += watch.lap();
    if (!std::isfinite(result.relative_residual)) break;
    // Loads below the round-off of the positions are solved for once; nothing better can be had after that.
    const bool all_that_positions_resolve = result.newton_iterations > 0 && norm <= force_round_off(d, result.u);
    if (result.relative_residual <= options.newton_residual || all_that_positions_resolve) {
      result.converged = true;
      break;
    }
    if (result.newton_iterations >= options.newton_iterations) break;
    BlockMatrix<double> A;
    A.reset(d.pattern);
    assemble_regular_cells(d, result.u, A);
    result.times.assemble_ms += watch.lap();
    assemble_hanging_cells(d, result.u, A);
    result.times.reduce_ms += watch.lap();
    apply_supports(d.supports, A);
    Eigen::VectorXd change;
    const SolveReport report =
        solve_linear(d, hierarchy, A, result.u, r, options, options.linear, x, factors, direct, change);
    result.linear_iterations += report.iterations;
    ++result.newton_iterations;
    if (!report.converged || !change.allFinite()) break;
    x = mixing.next(x, change);
    result.times.solve_ms += watch.lap();
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
                              const Eigen::Matrix3Xd& start, const EquilibriumOptions& options, FactorCache* factors) {
  FactorCache fresh;
  FactorCache& used = factors ? *factors : fresh;
  Eigen::VectorXd reduced_loads = reduce_forces(d.hanging, loads);
  if (!d.springs.empty())
    reduced_loads += reduce_forces(d.hanging, anchor_forces(d.springs, d.mesh, anchors_at(d.springs, 0.0)));
  return d.shapes.material().kinematics == Kinematics::linear
             ? solve_linear_equilibrium(d, hierarchy, reduced_loads, start, options, used)
             : solve_corotational_equilibrium(d, hierarchy, reduced_loads, start, options, used);
}

}  // namespace finegauge
