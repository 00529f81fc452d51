#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/tissue_step.hpp"

namespace finegauge {

/// Changes of the mesh without a jump.
///
/// After a change the same state has other internal forces, other lumped masses and other places where the needle
/// acts: a finer mesh is softer. Left to themselves these differences act at once, and all forces jump within a frame
/// to what the new mesh's equilibrium asks for. Instead, the difference itself is applied as a nodal load
///   r0 = e_new - Pᵀ e_old,   e = M a + f_int(u) + C v + Jᵀλ/τ - f_ext  in free directions,
/// with the accelerations a of the frame that has just ended, so that the new mesh goes on exactly as the old one would
/// have, its own out-of-balance forces e_old (what a linear solve leaves of a step) included. The load then fades
/// linearly: in the k-th frame after the change (N - k)/N of it act, from the N-th frame on nothing. So the change is
/// spread over N frames; 1, as 0, is all at once. Several changes fade side by side, each in its own N frames.
/// When the mesh changes again the loads go along (transfer_forces in space/transfer.hpp); what that alters is part of
/// the next change's r0.
///
/// Where the forces jump anyway, since a surface gave way or the needle cut on, all pending loads end at once: they
/// belong to a state that is no more, and would go on to strain the body after the needle's force is gone.
///
/// The loads do work, which has a place of its own in the energy ledger. Nothing is stored, or done, while no load is
/// pending.
struct MeshChangeRelease {
  Eigen::MatrixXd pending;       ///< a column for each change, oldest first: r0, reduced [N]
  std::vector<int> frames_left;  ///< per column, >= 1
  int frames = 0;                ///< N of all of them
  Eigen::VectorXd own_loads;     ///< the mesh's loads without the pending ones [N]; empty without any
  Eigen::VectorXd acting;        ///< what is in TissueMesh::loads beside them [N]; empty without any

  bool empty() const { return frames_left.empty(); }
};

/// At the start of a frame: the shares that act in it go to `mesh.loads`; when the last one is gone these are the bits
/// that they were built with.
void fade(MeshChangeRelease& release, TissueMesh& mesh);

/// Ends all pending loads.
void end_release(MeshChangeRelease& release, TissueMesh& mesh);

/// Work that the loads did in the last step [J].
double released_work(const MeshChangeRelease& release, const TissueMesh& mesh, const Eigen::Matrix3Xd& velocity,
                     double tau);

/// What the frame that has just ended tells of the accelerations and constraints.
struct EndedStep {
  const Eigen::Matrix3Xd& start_velocity;                                     ///< nodal, on the mesh of the step [m/s]
  const Eigen::VectorXd& constraint_impulse;                                  ///< Jᵀλ, reduced [N s]; may be empty
  std::function<Eigen::VectorXd(const TissueMesh&)> constraint_on_mesh = {};  ///< the same λ at the same material
                                                                              ///< points on another mesh; may be none
  double time = no_time;     ///< at the start of the step [s]; only moving springs ask for it
  bool forces_jump = false;  ///< in the next step: another law holds at the needle's tip
};

/// After a change: adds r0 of the change to the pending loads and takes these along. `before` is the state on the mesh
/// `from`, `after` on `to`; `to.loads` come as built and leave with what acts.
void release_change(const TissueProblem& problem, const TissueMesh& from, const TissueState& before,
                    const TissueState& after, const EndedStep& step, double tau, int frames, TissueMesh& to,
                    MeshChangeRelease& release);

}  // namespace finegauge
