#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/needle/contact_rows.hpp"
#include "core/needle/needle.hpp"
#include "core/solve/step_solver.hpp"
#include "core/space/block_matrix.hpp"
#include "core/space/supports.hpp"

namespace finegauge {

/// The frame's two systems and the points that couple them. All are borrowed.
struct InteractionSystem {
  const BlockMatrix<double>& A;  ///< tissue, supports applied; the matrix that the StepSolver was given last
  const Eigen::VectorXd& b;      ///< tissue, zero in held directions [N s]
  const Supports& supports;
  const Eigen::VectorXd& tissue_velocity;  ///< reduced v plus the prescribed part of dv [m/s]
  const ChainMatrix& needle_A;             ///< held dofs applied
  const Eigen::VectorXd& needle_b;         ///< zero in held dofs
  const HeldDofs& held;
  const Eigen::VectorXd& needle_velocity;  ///< v plus the prescribed part of dv
  std::span<const ContactRows> points;
  double tau;              ///< [s]
  double reference_speed;  ///< what violations are compared with [m/s], > 0
};

struct InteractionOptions {
  double weight = 1e4;      ///< κ: W = κ / (J diag(A)⁻¹ Jᵀ) of each row, both systems
  double tolerance = 1e-8;  ///< of the violation over reference_speed and of the change of λ over the largest λ
  int iterations = 100;     ///< of Uzawa
  int patience = 12;        ///< iterations after which the active set changes with care
};

/// What became of a point's rows.
struct ContactOutcome {
  Eigen::Vector3d lambda = Eigen::Vector3d::Zero();    ///< [N s], in the frame
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< relative velocity r after the step, in the frame [m/s]
  int axial_slip = 0;  ///< friction: +1 at the bound against advance, -1 at that against withdrawal, 0 sticks
  bool lateral_slip = false;
};

struct [[nodiscard]] Interaction {
  Eigen::VectorXd tissue, needle;  ///< dv, free part (zero in held directions)
  std::vector<ContactOutcome> points;
  bool converged = false;          ///< all of: violation, change of λ, active set, linear solves
  int iterations = 0;              ///< of Uzawa
  int linear_iterations = 0;       ///< summed
  double violation = 0.0;          ///< largest of contact_violation (contact_law.hpp), over reference_speed
  double multiplier_change = 0.0;  ///< last, over the largest |λ| (or what stops a point at reference_speed)
  double residual = 0.0;  ///< of the tissue, true: ‖b - Jᵀλ - A dv‖ over the largest of the three norms;
                          ///< infinite where A is not finite
};

/// Augmented Lagrangian: Uzawa's iteration on (A + J_aᵀ W J_a) dv = b - Jᵀ λ + J_aᵀ W rhs, rhs = -(J v + g/τ),
/// λ <- λ + W (J dv - rhs) projected onto its cone (contact_law.hpp); rows at their bound are out of J_a with their
/// impulse fixed until the slip reverses. Many rows that change at once can go on changing without an end where they
/// depend on one another, as the friction of points in one cell does: what they need together to hold pushes some of
/// them forward and others back. So after some iterations λ goes only so far towards what the holding rows ask for as
/// the first bound allows, and rows return after whole steps alone: an active-set method for the quadratic program of
/// the impulses (Nocedal, Wright, Numerical Optimization, 2006, section 16.5), which descends and cannot cycle while
/// the bounds stay. Points under Coulomb's law then change one at a time, the first in order.
/// Needle and tissue stay two systems: the needle is eliminated exactly, so its stiffness does not condition the
/// tissue's. With G_n = J_n A_n⁻¹ J_nᵀ and S = (W⁻¹ + G_n)⁻¹,
///   (A_t + J_tᵀ S J_t) dv_t = b_t - J_tᵀ S (W⁻¹ λ + J_n A_n⁻¹ b_n - rhs),
///   the new λ = S (W⁻¹ λ + J_n A_n⁻¹ b_n - rhs + J_t dv_t),  dv_n = A_n⁻¹ (b_n - J_nᵀ λ).
/// A lateral slip keeps the part of its row's stiffness with which its impulse turns, λ_t = bound p/|p|,
/// p = λ_t + W r. Bounds are those of the last λ. Without points it is one solve of each system. A system that cannot
/// be solved, or not within the iterations, is returned as not converged, finite, with λ inside its cone.
/// Bilateral points closer to one another than about half a cell have rows that the tissue can hardly tell apart: their
/// impulses alternate in sign, and iterations grow from 4 to 6 to a hundred, since the smallest eigenvalue of J A⁻¹ Jᵀ
/// falls towards the needle's own compliance. The remedy is the points' spacing, not κ.
/// Not covered: friction along the needle together with Coulomb's law across it at one point (asserted).
Interaction solve_interaction(const InteractionSystem& system, const InteractionOptions& options, StepSolver& solver);

}  // namespace finegauge
