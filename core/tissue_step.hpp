#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/solve/solve_report.hpp"
#include "core/space/assembly.hpp"
#include "core/space/discretization.hpp"
#include "core/space/loads.hpp"

namespace finegauge {

/// A body that moves, but for its mesh.
struct TissueProblem {
  Material material;
  double density = 1000.0;                            ///< ρ [kg/m³]
  double mass_damping = 0.0;                          ///< Rayleigh's α in C = α M + β K [1/s]
  double stiffness_damping = 0.0;                     ///< β [s]
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< [m/s²]
  std::vector<SupportCondition> supports;             ///< moving ones by SupportCondition::course
  std::vector<SpringSupport> springs;                 ///< part of K; anchors move by SpringSupport::course
  std::vector<SurfaceLoad> loads;                     ///< constant in time
  BodyForce body;
};

/// Nodal and conforming, 3 × n_nodes.
struct TissueState {
  Eigen::Matrix3Xd u;  ///< displacement [m]
  Eigen::Matrix3Xd v;  ///< velocity [m/s]
};

/// All that follows from a mesh for motion: rebuilt with it.
struct TissueMesh {
  Discretization d;
  Eigen::VectorXd mass;   ///< per reduced node [kg]
  Eigen::VectorXd loads;  ///< reduced external forces with gravity [N]
};
TissueMesh build_tissue_mesh(const RefinementForest& forest, const TissueProblem& problem);
/// Of a `forest.leaf_mesh()` of the forest as it is now.
TissueMesh build_tissue_mesh(const RefinementForest& forest, Mesh mesh, const TissueProblem& problem);

/// The linear system of a step of backward Euler with K and C positive:
///   A = M + τ C + τ² K,  b = τ f(u, v) - τ² K v,  f = f_ext - f_int(u) - C v,  dv = v(t+τ) - v(t)
/// (Baraff & Witkin 1998; the paper's signs are those of force Jacobians), reduced, supports applied. K is frozen at
/// the rotations of u. In held directions dv is prescribed: v(t+τ) = (u_prescribed(t+τ) - u)/τ. Springs are part of K
/// and of f_int as if their anchors rested; what the anchors add, k (a(t+τ) + β (a(t+τ) - a(t))/τ), is part of f_ext.
/// A node whose cells have no material has no mass; K holds it, by the least share of stiffness (mesh.hpp).
struct TissueSystem {
  BlockMatrix<double> A;
  Eigen::VectorXd b;           ///< free directions only, the prescribed part of dv carried over [N s]
  Eigen::VectorXd prescribed;  ///< dv in held directions, zero elsewhere [m/s]
  Eigen::VectorXd velocity;    ///< reduced v at the start [m/s]
  Eigen::VectorXd internal;    ///< reduced internal forces at the displacement linearized about [N]

  std::vector<Eigen::Vector3d> support_displacement;  ///< prescribed at the step's end, per entry of Supports [m]
  Eigen::VectorXd product;                            ///< scratch
};
/// `system` is overwritten; its buffers are used again.
void assemble_step(const TissueMesh& mesh, const TissueProblem& problem, const TissueState& state, double time,
                   double tau, TissueSystem& system);
/// The same step linearized again about a guess v⁺ of the end velocity (reduced), rotations frozen at u + τ v⁺:
///   A as above,  b = τ f(u + τ v⁺, v⁺) - M (v⁺ - v);  dv is then the correction of v⁺.
void assemble_newton_step(const TissueMesh& mesh, const TissueProblem& problem, const TissueState& state,
                          const Eigen::VectorXd& end_velocity, double time, double tau, TissueSystem& system);
/// v <- v + dv, u <- u + τ v; dv = free + prescribed part, reduced.
void update(const TissueMesh& mesh, const Eigen::VectorXd& dv, double tau, TissueState& state);

/// Impulses [N s] by which a state misses the implicit step.
struct OutOfBalance {
  double norm = 0.0;
  double scale = 0.0;  ///< the largest of the terms' norms
  double error() const { return scale > 0.0 ? norm / scale : 0.0; }
};
/// Whether Newton's iteration is at its end: what is left is small against the terms, or no more than the round-off of
/// the positions makes of terms that are nothing themselves.
bool is_balanced(const OutOfBalance& left, double relative, const TissueMesh& mesh, const TissueState& state,
                 double tau);

/// Out-of-balance impulses of the implicit step that a single linear solve leaves over,
///   M (v⁺ - v) - τ f(u⁺, v⁺) + Jᵀλ in free directions,
/// and the largest of the terms' norms (reactions included, but not loads on held directions).
/// `constraint_impulse` is Jᵀλ, reduced, may be empty. `start_velocity`: reduced v before the step; `state` after.
/// `time` [s]: at the start of the step; only moving springs ask for it.
OutOfBalance out_of_balance(const TissueMesh& mesh, const TissueProblem& problem, const TissueState& state,
                            const Eigen::VectorXd& start_velocity, const Eigen::VectorXd& constraint_impulse,
                            double tau, double time = no_time);

/// Energies [J] of a state.
struct TissueEnergy {
  double kinetic = 0.0;
  double elastic = 0.0;  ///< stored, in the body and in its springs
  double sum() const { return kinetic + elastic; }
};
/// `time` [s]: of the state; only moving springs ask for it.
TissueEnergy tissue_energy(const TissueMesh& mesh, const TissueState& state, double time = no_time);
Eigen::Vector3d linear_momentum(const TissueMesh& mesh, const TissueState& state);  ///< [kg m/s]
/// About the origin, at current positions [kg m²/s]. Not conserved: frozen rotations are not free of torque.
Eigen::Vector3d angular_momentum(const TissueMesh& mesh, const TissueState& state);

/// What a step did to the energy [J]. Scalar product of the implicit step with v⁺, term by term:
///   change of kinetic + elastic
///     = loads + supports + springs + constraints + unbalanced - damping - numerical + remainder.
/// The remainder vanishes to round-off for linear kinematics. For corotational ones it does not, and has either sign:
/// the internal force leaves out how rotations change and so is not the gradient of the elastic energy.
struct TissueWork {
  double loads = 0.0;        ///< by external forces and gravity, f_extᵀ (u⁺ - u)
  double supports = 0.0;     ///< by moving supports: reaction impulse times prescribed velocity
  double springs = 0.0;      ///< by moving anchors: the springs' forces on the body at the end times a⁺ - a
  double constraints = 0.0;  ///< by constraint impulses, -(Jᵀλ)ᵀ v⁺
  double unbalanced = 0.0;   ///< by the impulses that equilibrium_error measures; zero when the step is solved exactly
  double damping = 0.0;      ///< dissipated by Rayleigh damping, τ v⁺ᵀ C v⁺ >= 0; of springs by u̇ - ȧ
  double numerical = 0.0;  ///< dissipated by backward Euler, 1/2 dvᵀ M dv + 1/2 τ² v⁺ᵀ K v⁺ >= 0; of springs likewise

  /// What the change of kinetic + elastic energy should be.
  double sum() const { return loads + supports + springs + constraints + unbalanced - damping - numerical; }
};
/// `time` [s]: at the start of the step; only moving springs ask for it.
TissueWork tissue_work(const TissueMesh& mesh, const TissueProblem& problem, const TissueState& before,
                       const TissueState& after, const Eigen::VectorXd& constraint_impulse, double tau,
                       double time = no_time);

using LinearSolve =
    std::function<SolveReport(const BlockMatrix<double>& A, const Eigen::VectorXd& b, Eigen::VectorXd& x)>;
struct TissueStepOptions {
  int newton_iterations = 1;      ///< linear solves at most; 1: the paper's single one
  double newton_residual = 1e-9;  ///< equilibrium_error at which Newton stops
};
struct [[nodiscard]] TissueStepReport {
  bool converged = false;  ///< linear solves, and Newton where asked for
  int newton_iterations = 0, linear_iterations = 0;
  double residual = 0.0;  ///< of the last linear solve
  double equilibrium_error = 0.0;
};
/// A whole step without constraints. Newton's steps are mixed with the ones before (anderson_mixing.hpp): the tangent
/// leaves the turning of the stresses out. It also ends as converged where the residual is below what the round-off of
/// the positions alone causes. A solve that is not finite leaves the state as it was.
TissueStepReport step_tissue(const TissueMesh& mesh, const TissueProblem& problem, double time, double tau,
                             const TissueStepOptions& options, const LinearSolve& solve, TissueSystem& system,
                             TissueState& state);

/// What a change of mesh did.
struct TransferLedger {
  double elastic_change = 0.0, kinetic_change = 0.0;          ///< after minus before [J]
  Eigen::Vector3d support_impulse = Eigen::Vector3d::Zero();  ///< taken by the supports of coarsened cells [kg m/s]
  double momentum_change = 0.0;  ///< ‖Δp + support_impulse‖ / (mass × largest speed): round-off
  /// Of the angular momentum about the origin, at current positions, with the supports' impulses taken back
  /// [kg m²/s]: what could not be kept, see below.
  Eigen::Vector3d angular_change = Eigen::Vector3d::Zero();
  int moved = 0;  ///< nodes whose velocity is not that of the old field there
};
/// u and v on another mesh of the same forest. Refinement keeps both fields exactly, and the momentum; the lumped
/// kinetic energy falls, since a finer mesh lumps less. Coarsening keeps u at the nodes that remain. v becomes the
/// adjoint interpolation of the momentum, v_c = M_c⁻¹ Pᵀ M_f v_f with P from the coarse to the fine nodes: each
/// velocity is a mean of the old ones, so uniform motion is kept, linear momentum and (about rest positions) angular
/// momentum too, and by Jensen's inequality no kinetic energy is added. Nodes whose function did not change keep their
/// velocity, and held directions the prescribed one.
///
/// No transfer can do that and be the identity after a refinement: going fine lost kinetic energy, which would have to
/// come back. So u comes back from a round trip, and v comes back smoothed. Nor can refinement keep the field and the
/// angular momentum: a finer mesh lumps less mass far out, so that the same turning has less of it. The ledger says
/// how much; of a body that coarsens only what the displacements given up carry at current positions.
///
/// Where T gives up a bend, has negative weights, or a cell was refined beside one that was coarsened in the same
/// change, M_c is not Pᵀ M_f 1: the momentum left over is then shared among the moved nodes, where cells were only
/// coarsened the angular momentum (at rest positions, about the centre of mass) too, and the kinetic energy is bounded
/// only by what the ledger says. So it is in cells that are filled in part, whose children know better where the mass
/// is. Where such cells are refined, the same velocities carry other masses; what that loses is shared among the new
/// nodes that depend on them, and only theirs is not the old field. Uniform motion stays uniform. Nodes without mass
/// have the old field's velocity. `time` [s]: of the state; only the ledger's elastic energy of moving springs asks for
/// it.
TissueState transfer_state(const TissueMesh& from, const TissueState& state, const TissueMesh& to,
                           TransferLedger* ledger, double time = no_time);

}  // namespace finegauge
