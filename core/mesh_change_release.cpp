#include "core/mesh_change_release.hpp"

#include <cassert>

#include "core/space/transfer.hpp"
#include "core/tissue_forces.hpp"

namespace finegauge {
namespace {

/// e = M a + f_int + C v + Jᵀλ/τ - loads in free directions, reduced [N]; springs with their anchors included.
Eigen::VectorXd out_of_balance_forces(const TissueMesh& mesh, const TissueProblem& problem, const TissueState& state,
                                      const Eigen::VectorXd& acceleration, const Eigen::VectorXd& constraint_impulse,
                                      const Eigen::VectorXd& loads, double time, double tau) {
  const TissueForces forces = tissue_forces(mesh.d, state.u, state.v);
  const Eigen::VectorXd v = gather(mesh.d.hanging, state.v);
  Eigen::VectorXd e = mass_times(mesh.mass, acceleration + problem.mass_damping * v) + forces.internal +
                      problem.stiffness_damping * forces.stiff - loads;
  if (!mesh.d.springs.empty()) e -= anchor_loads(mesh.d, problem.stiffness_damping, time, tau);
  if (constraint_impulse.size() > 0) e += constraint_impulse / tau;
  project(mesh.d.supports, e);
  return e;
}

/// Sum of the columns' shares in the frame that has just ended, or been started by fade().
Eigen::VectorXd acting_loads(const MeshChangeRelease& release) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(release.pending.rows());
  for (Eigen::Index k = 0; k < release.pending.cols(); ++k)
    sum += release.frames_left[k] / static_cast<double>(release.frames) * release.pending.col(k);
  return sum;
}

}  // namespace

void fade(MeshChangeRelease& release, TissueMesh& mesh) {
  if (release.empty()) return;
  for (int& left : release.frames_left) --left;
  Eigen::Index gone = 0;
  while (gone < static_cast<Eigen::Index>(release.frames_left.size()) && release.frames_left[gone] == 0) ++gone;
  if (gone > 0) {
    release.frames_left.erase(release.frames_left.begin(), release.frames_left.begin() + gone);
    release.pending = release.pending.rightCols(release.pending.cols() - gone).eval();
  }
  mesh.loads = release.own_loads;
  if (release.empty()) {
    release = {};
    return;
  }
  release.acting = acting_loads(release);
  mesh.loads += release.acting;
}

void end_release(MeshChangeRelease& release, TissueMesh& mesh) {
  if (release.empty()) return;
  mesh.loads = release.own_loads;
  release = {};
}

double released_work(const MeshChangeRelease& release, const TissueMesh& mesh, const Eigen::Matrix3Xd& velocity,
                     double tau) {
  return release.empty() ? 0.0 : tau * release.acting.dot(gather(mesh.d.hanging, velocity));
}

void release_change(const TissueProblem& problem, const TissueMesh& from, const TissueState& before,
                    const TissueState& after, const EndedStep& step, double tau, int frames, TissueMesh& to,
                    MeshChangeRelease& release) {
  assert(release.empty() || release.frames == frames);
  const Eigen::Matrix3Xd acceleration = (before.v - step.start_velocity) / tau;
  const Eigen::VectorXd e_old = out_of_balance_forces(from, problem, before, gather(from.d.hanging, acceleration),
                                                      step.constraint_impulse, from.loads, step.time, tau);
  // One pass for all vectors: the pending loads, then e_old.
  const Eigen::Index pending = release.pending.cols();
  Eigen::MatrixXd forces(e_old.size(), pending + 1);
  if (pending > 0) forces.leftCols(pending) = release.pending;
  forces.col(pending) = e_old;
  release.pending = transfer_forces(from.d, forces, to.d);
  for (Eigen::Index k = 0; k <= pending; ++k) {
    Eigen::VectorXd load = release.pending.col(k);  // may have come to a node that is held
    project(to.d.supports, load);
    release.pending.col(k) = load;
  }

  const Eigen::VectorXd carried = release.pending.col(pending);
  release.own_loads = to.loads;
  release.frames = frames;
  release.pending.col(pending).setZero();
  release.frames_left.push_back(frames);
  to.loads += acting_loads(release);
  Eigen::VectorXd impulse;
  if (step.constraint_on_mesh) impulse = step.constraint_on_mesh(to);
  Eigen::VectorXd r0 =
      out_of_balance_forces(to, problem, after, gather(to.d.hanging, transfer(from.d.mesh, acceleration, to.d.mesh)),
                            impulse, to.loads, step.time, tau) -
      carried;
  project(to.d.supports, r0);
  to.loads += r0;
  release.pending.col(pending) = r0;
  release.acting = to.loads - release.own_loads;
}

}  // namespace finegauge
