// A user's program: a cube with its bottom clamped, pulled at its top, refined once in one corner.
#include <cstdio>

#include "core/equilibrium.hpp"

using namespace finegauge;

// Another alignment than the library's would be another layout of its structs.
static_assert(EIGEN_MAX_STATIC_ALIGN_BYTES == 64 && EIGEN_MAX_ALIGN_BYTES == 64);

int main() {
  RefinementForest forest(box_mesh(BoxMeshOptions{.cells = {4, 4, 4}}));
  forest.refine(0, {.divisions = {2, 2, 2}});

  const Material material{.youngs_modulus = 1.0e3, .poisson_ratio = 0.3};
  const std::vector<SupportCondition> supports = {{.surface = "z_min"}};
  const Discretization discretization = discretize(forest, material, supports);

  const Eigen::Matrix3Xd loads =
      nodal_loads(forest.base(), discretization.mesh,
                  {{.surface = "z_max", .kind = LoadKind::traction, .value = {0.0, 0.0, 10.0}}});
  const MeshHierarchy hierarchy = build_hierarchy(forest, discretization, supports);
  const Eigen::Matrix3Xd at_rest = Eigen::Matrix3Xd::Zero(3, discretization.mesh.node_count());
  const Equilibrium equilibrium = solve_equilibrium(discretization, hierarchy, loads, at_rest);

  std::printf("%d cells, %d of %d nodes hang\n", discretization.mesh.cell_count(),
              discretization.hanging.hanging_count(), discretization.mesh.node_count());
  std::printf("converged %d, energy %.6e J\n", int(equilibrium.converged), equilibrium.energy);
  return equilibrium.converged ? 0 : 1;
}
