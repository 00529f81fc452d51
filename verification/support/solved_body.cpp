#include "verification/support/solved_body.hpp"

#include <stdexcept>
#include <string>

#include "core/adapt/stress_recovery.hpp"
#include "core/equilibrium.hpp"

namespace finegauge {

SolvedBody solve_body(const RefinementForest& forest, const Material& material,
                      const std::vector<SupportCondition>& supports, const NodalLoads& loads) {
  SolvedBody body;
  body.d = discretize(forest, material, supports);
  const MeshHierarchy hierarchy = build_hierarchy(forest, body.d, supports);
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, body.d.mesh.node_count());
  EquilibriumOptions options;
  options.linear.relative_residual = 1e-9;
  const Equilibrium solved =
      solve_equilibrium(body.d, hierarchy, loads ? loads(forest.base(), body.d.mesh) : none, none, options);
  if (!solved.converged)
    throw std::runtime_error("a solve ended at a relative residual of " + std::to_string(solved.relative_residual));
  body.u = solved.u;
  body.relative_residual = solved.relative_residual;
  body.nodal_stress = recover_stress_spr(body.d, cell_stresses(body.d, body.u));
  return body;
}

}  // namespace finegauge
