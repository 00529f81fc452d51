#include <Eigen/Geometry>

#include "core/tissue_forces.hpp"
#include "core/tissue_step.hpp"

namespace finegauge {

TissueEnergy tissue_energy(const TissueMesh& mesh, const TissueState& state) {
  TissueEnergy energy;
  for (Eigen::Index i = 0; i < mesh.mass.size(); ++i)
    energy.kinetic += 0.5 * mesh.mass[i] * state.v.col(mesh.d.hanging.node_of[i]).squaredNorm();
  energy.elastic = 0.5 * strain_energy_product(mesh.d, state.u);
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
                       const TissueState& after, const Eigen::VectorXd& constraint_impulse, double tau) {
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
