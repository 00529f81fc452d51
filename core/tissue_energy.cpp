#include <Eigen/Geometry>

#include "core/tissue_forces.hpp"
#include "core/tissue_step.hpp"

namespace finegauge {
namespace {

/// Per spring with w = u - a and the force f = -k w⁺ - β k Δw/τ on the body, what the step does to its energy is
///   1/2 k |w⁺|² - 1/2 k |w|² = f·Δa - f·Δu - β k |Δw|²/τ - 1/2 k |Δw|².
/// The terms of the body at large have Δu in place of Δw, as for anchors at rest: the difference goes to them here.
void add_anchor_work(const Discretization& d, double stiffness_damping, const Eigen::Matrix3Xd& u_before,
                     const Eigen::Matrix3Xd& u_after, double time, double tau, TissueWork& work) {
  const std::vector<Eigen::Vector3d> a_before = anchors_at(d.springs, time);
  const std::vector<Eigen::Vector3d> a_after = anchors_at(d.springs, time + tau);
  for (std::size_t p = 0; p < d.springs.points.size(); ++p) {
    const Springs::Point& point = d.springs.points[p];
    const LeafPoint at{point.cell, point.xi};
    const Eigen::Vector3d u = interpolate(d.mesh, u_after, at), du = u - interpolate(d.mesh, u_before, at);
    const Eigen::Vector3d da = a_after[p] - a_before[p], dw = du - da;
    const double k = point.stiffness, damping = stiffness_damping / tau * k;
    work.springs += (-k * (u - a_after[p]) - damping * dw).dot(da);
    // |Δw|² - |Δu|²
    const double difference = -da.dot(du + dw);
    work.damping += damping * difference;
    work.numerical += 0.5 * k * difference;
  }
}

}  // namespace

TissueEnergy tissue_energy(const TissueMesh& mesh, const TissueState& state, double time) {
  TissueEnergy energy;
  for (Eigen::Index i = 0; i < mesh.mass.size(); ++i)
    energy.kinetic += 0.5 * mesh.mass[i] * state.v.col(mesh.d.hanging.node_of[i]).squaredNorm();
  energy.elastic = 0.5 * strain_energy_product(mesh.d, state.u);
  if (!mesh.d.springs.empty()) energy.elastic += spring_energy(mesh.d.springs, mesh.d.mesh, state.u, time);
  return energy;
}

Eigen::Vector3d linear_momentum(const TissueMesh& mesh, const TissueState& state) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < mesh.mass.size(); ++i) p += mesh.mass[i] * state.v.col(mesh.d.hanging.node_of[i]);
  return p;
}

Eigen::Vector3d angular_momentum(const TissueMesh& mesh, const TissueState& state) {
  Eigen::Vector3d L = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < mesh.mass.size(); ++i) {
    const int node = mesh.d.hanging.node_of[i];
    const Eigen::Vector3d x = mesh.d.mesh.nodes.col(node) + state.u.col(node);
    L += mesh.mass[i] * x.cross(state.v.col(node));
  }
  return L;
}

TissueWork tissue_work(const TissueMesh& mesh, const TissueProblem& problem, const TissueState& before,
                       const TissueState& after, const Eigen::VectorXd& constraint_impulse, double tau, double time) {
  const Eigen::VectorXd v = gather(mesh.d.hanging, after.v);
  const Eigen::VectorXd dv = v - gather(mesh.d.hanging, before.v);
  const TissueForces forces = tissue_forces(mesh.d, after.u, after.v);
  const Eigen::VectorXd damping =
      tau * (problem.mass_damping * mass_times(mesh.mass, v) + problem.stiffness_damping * forces.stiff);
  const Eigen::VectorXd inertia = mass_times(mesh.mass, dv);

  TissueWork work;
  work.loads = tau * mesh.loads.dot(v);
  work.damping = damping.dot(v);
  work.numerical = 0.5 * dv.dot(inertia) + 0.5 * tau * tau * v.dot(forces.stiff);
  // What the implicit step lacks: in held directions the supports' reaction, elsewhere out of balance.
  Eigen::VectorXd lacking = inertia - tau * mesh.loads + tau * forces.internal + damping;
  if (!mesh.d.springs.empty()) {
    lacking -= tau * anchor_loads(mesh.d, problem.stiffness_damping, time, tau);
    add_anchor_work(mesh.d, problem.stiffness_damping, before.u, after.u, time, tau, work);
  }
  if (constraint_impulse.size() > 0) {
    work.constraints = -constraint_impulse.dot(v);
    lacking += constraint_impulse;
  }
  Eigen::VectorXd unbalanced = lacking;
  project(mesh.d.supports, unbalanced);
  work.unbalanced = unbalanced.dot(v);
  work.supports = (lacking - unbalanced).dot(v);
  return work;
}

}  // namespace finegauge
