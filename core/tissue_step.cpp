#include "core/tissue_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/solve/anderson_mixing.hpp"
#include "core/space/lumped_mass.hpp"
#include "core/tissue_forces.hpp"

namespace finegauge {
namespace {

/// Impulses [N s] that the round-off of the positions alone can cause (as in static equilibrium).
double impulse_round_off(const TissueMesh& mesh, const TissueState& state, double tau) {
  const Material& material = mesh.d.shapes.material();
  const Mesh& cells = mesh.d.mesh;
  const double extent = (cells.nodes + state.u).cwiseAbs().maxCoeff();
  const Eigen::Vector3d size = cells.nodes.rowwise().maxCoeff() - cells.nodes.rowwise().minCoeff();
  const double cell_size = std::cbrt(size.prod() / cells.cell_count());
  return tau * std::numeric_limits<double>::epsilon() * (material.bulk() + 2.0 * material.mu()) * cell_size * extent *
         std::sqrt(static_cast<double>(mesh.d.dof_count()));
}

/// K at u into A, and K v into `system.product`; f_int into `system.internal`.
void assemble_tissue(const TissueMesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::VectorXd& v,
                     TissueSystem& system) {
  system.A.reset(mesh.d.pattern);
  assemble_regular_cells(mesh.d, u, system.A);
  assemble_hanging_cells(mesh.d, u, system.A);
  multiply(system.A, v, system.product);
  system.internal = reduce_forces(mesh.d.hanging, internal_forces(mesh.d, u));
}

/// From K to A = M + τ C + τ² K; then what the supports prescribe goes to the right-hand side. `from`: the reduced
/// velocity that dv is added to.
void finish_system(const TissueMesh& mesh, const TissueProblem& problem, const Eigen::Matrix3Xd& start_displacement,
                   const Eigen::VectorXd& from, double time, double tau, TissueSystem& system) {
  const Supports& supports = mesh.d.supports;
  const double stiffness = tau * problem.stiffness_damping + tau * tau;
  for (double& value : system.A.values) value *= stiffness;
  for (int i = 0; i < mesh.d.pattern.size(); ++i)
    system.A.block(mesh.d.pattern.diagonal[i]).diagonal().array() += (1.0 + tau * problem.mass_damping) * mesh.mass[i];

  prescribe(supports, time + tau, system.support_displacement);
  system.prescribed.setZero(from.size());
  bool moves = false;
  for (std::size_t s = 0; s < supports.reduced.size(); ++s) {
    const int i = supports.reduced[s];
    const Eigen::Vector3d end_velocity =
        (system.support_displacement[s] - start_displacement.col(mesh.d.hanging.node_of[i])) / tau;
    const Eigen::Vector3d dv = supports.held[s] * (end_velocity - from.segment<3>(3 * i));
    system.prescribed.segment<3>(3 * i) = dv;
    moves = moves || !dv.isZero(0.0);
  }
  if (moves) {
    multiply(system.A, system.prescribed, system.product);
    system.b -= system.product;
  }
  project(supports, system.b);
  apply_supports(supports, system.A);
}

/// u <- u + τ v with the end velocity v, reduced.
void move_with(const TissueMesh& mesh, const Eigen::VectorXd& v, double tau, TissueState& state) {
  state.v = expand(mesh.d.hanging, v);
  state.u = expand(mesh.d.hanging, gather(mesh.d.hanging, state.u) + tau * v);
}

/// Solves for dv, held directions included.
SolveReport solve_system(const Supports& supports, const TissueSystem& system, const LinearSolve& solve,
                         Eigen::VectorXd& dv) {
  dv.setZero(system.b.size());
  const SolveReport report = solve(system.A, system.b, dv);
  project(supports, dv);
  dv += system.prescribed;
  return report;
}

}  // namespace

TissueMesh build_tissue_mesh(const RefinementForest& forest, const TissueProblem& problem) {
  return build_tissue_mesh(forest, forest.leaf_mesh(), problem);
}

TissueMesh build_tissue_mesh(const RefinementForest& forest, Mesh leaves, const TissueProblem& problem) {
  TissueMesh mesh;
  mesh.d = discretize(forest, std::move(leaves), problem.material, problem.supports, problem.springs);
  mesh.mass = lumped_mass(mesh.d, problem.density);
  mesh.loads = reduce_forces(mesh.d.hanging, nodal_loads(forest.base(), mesh.d.mesh, problem.loads, problem.body));
  // By the lumped mass, not by integration: every node then falls alike, whatever the mesh.
  for (Eigen::Index i = 0; i < mesh.mass.size(); ++i) mesh.loads.segment<3>(3 * i) += mesh.mass[i] * problem.gravity;
  return mesh;
}

void assemble_step(const TissueMesh& mesh, const TissueProblem& problem, const TissueState& state, double time,
                   double tau, TissueSystem& system) {
  system.velocity = gather(mesh.d.hanging, state.v);
  assemble_tissue(mesh, state.u, system.velocity, system);
  const double stiffness = tau * problem.stiffness_damping + tau * tau;
  system.b = tau * (mesh.loads - system.internal) - stiffness * system.product;
  if (problem.mass_damping != 0.0) system.b -= tau * problem.mass_damping * mass_times(mesh.mass, system.velocity);
  if (!mesh.d.springs.empty()) system.b += tau * anchor_loads(mesh.d, problem.stiffness_damping, time, tau);
  finish_system(mesh, problem, state.u, system.velocity, time, tau, system);
}

void assemble_newton_step(const TissueMesh& mesh, const TissueProblem& problem, const TissueState& state,
                          const Eigen::VectorXd& end_velocity, double time, double tau, TissueSystem& system) {
  system.velocity = gather(mesh.d.hanging, state.v);
  const Eigen::Matrix3Xd end = expand(mesh.d.hanging, gather(mesh.d.hanging, state.u) + tau * end_velocity);
  assemble_tissue(mesh, end, end_velocity, system);
  system.b = tau * (mesh.loads - system.internal) - tau * problem.stiffness_damping * system.product -
             mass_times(mesh.mass, (1.0 + tau * problem.mass_damping) * end_velocity - system.velocity);
  if (!mesh.d.springs.empty()) system.b += tau * anchor_loads(mesh.d, problem.stiffness_damping, time, tau);
  finish_system(mesh, problem, state.u, end_velocity, time, tau, system);
}

void update(const TissueMesh& mesh, const Eigen::VectorXd& dv, double tau, TissueState& state) {
  move_with(mesh, gather(mesh.d.hanging, state.v) + dv, tau, state);
}

OutOfBalance out_of_balance(const TissueMesh& mesh, const TissueProblem& problem, const TissueState& state,
                            const Eigen::VectorXd& start_velocity, const Eigen::VectorXd& constraint_impulse,
                            double tau, double time) {
  const Eigen::VectorXd v = gather(mesh.d.hanging, state.v);
  const TissueForces forces = tissue_forces(mesh.d, state.u, state.v);
  const Eigen::VectorXd inertia = mass_times(mesh.mass, v - start_velocity);
  const Eigen::VectorXd damping =
      tau * (problem.mass_damping * mass_times(mesh.mass, v) + problem.stiffness_damping * forces.stiff);
  Eigen::VectorXd loads = tau * mesh.loads;
  if (!mesh.d.springs.empty()) loads += tau * anchor_loads(mesh.d, problem.stiffness_damping, time, tau);
  project(mesh.d.supports, loads);
  Eigen::VectorXd r = inertia - loads + tau * forces.internal + damping;
  if (constraint_impulse.size() > 0) r += constraint_impulse;
  project(mesh.d.supports, r);
  const double scale =
      std::max({inertia.norm(), loads.norm(), tau * forces.internal.norm(), damping.norm(), constraint_impulse.norm()});
  return {r.norm(), scale};
}

bool is_balanced(const OutOfBalance& left, double relative, const TissueMesh& mesh, const TissueState& state,
                 double tau) {
  return left.error() <= relative || left.norm <= impulse_round_off(mesh, state, tau);
}

TissueStepReport step_tissue(const TissueMesh& mesh, const TissueProblem& problem, double time, double tau,
                             const TissueStepOptions& options, const LinearSolve& solve, TissueSystem& system,
                             TissueState& state) {
  TissueStepReport report;
  const Eigen::VectorXd none;
  std::optional<AndersonMixing> mixing;
  Eigen::VectorXd v, dv;  // v: the end velocity so far
  TissueState end;
  for (;;) {
    if (report.newton_iterations == 0)
      assemble_step(mesh, problem, state, time, tau, system);
    else
      assemble_newton_step(mesh, problem, state, v, time, tau, system);
    const SolveReport linear = solve_system(mesh.d.supports, system, solve, dv);
    ++report.newton_iterations;
    report.linear_iterations += linear.iterations;
    report.residual = linear.relative_residual;
    // The first solve freezes other rotations than the map that is iterated after it, so it is not mixed.
    if (report.newton_iterations == 2) mixing.emplace(mixing_depth);
    const Eigen::VectorXd next = mixing ? mixing->next(v, dv) : Eigen::VectorXd(system.velocity + dv);
    if (!next.allFinite()) {
      report.converged = false;
      report.equilibrium_error = report.newton_iterations == 1 ? 1.0 : report.equilibrium_error;
      break;
    }
    v = next;
    end = state;
    move_with(mesh, v, tau, end);  // from v itself: over a long step v - v(t) has lost its digits
    const OutOfBalance left = out_of_balance(mesh, problem, end, system.velocity, none, tau, time);
    report.equilibrium_error = left.error();
    report.converged = linear.converged;
    if (!linear.converged || options.newton_iterations <= 1) break;
    if (is_balanced(left, options.newton_residual, mesh, end, tau)) break;
    report.converged = false;
    if (report.newton_iterations >= options.newton_iterations) break;
  }
  if (v.size() > 0) state = end;
  return report;
}

}  // namespace finegauge
