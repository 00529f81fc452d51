#include "benchmarks/micro/lshape_workload.hpp"

#include <dlfcn.h>

#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/adapt/apply_refinements.hpp"
#include "core/adapt/marking.hpp"

namespace finegauge {

/// Which BLAS is installed and whether OpenMP is there is found at run time; what is not there needs nothing.
void use_one_thread() {
  for (const char* name : {"openblas_set_num_threads", "omp_set_num_threads"})
    if (void* const symbol = dlsym(RTLD_DEFAULT, name)) reinterpret_cast<void (*)(int)>(symbol)(1);
}

namespace {

std::unique_ptr<LshapeWorkload> solved(LshapeProblem problem) {
  auto work = std::make_unique<LshapeWorkload>(LshapeWorkload{std::move(problem), {}, {}, {}, {}, {}});
  work->discretization = discretize(work->problem.forest, work->problem.material, work->problem.supports);
  const Discretization& d = work->discretization;
  work->hierarchy = build_hierarchy(work->problem.forest, d, work->problem.supports);
  work->loads = nodal_loads(work->problem.forest.base(), d.mesh, work->problem.loads);
  EquilibriumOptions options;
  options.linear.relative_residual = 1e-8;
  const Eigen::Matrix3Xd start = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  work->solution = solve_equilibrium(d, work->hierarchy, work->loads, start, options);
  if (!work->solution.converged) throw std::runtime_error("the L-shape could not be solved");
  work->estimate = estimate_error_spr(d, work->solution.u);
  return work;
}

std::unique_ptr<LshapeWorkload> uniform_workload(int dofs) {
  LshapeProblem problem = lshape_problem();
  for (;;) {
    const Mesh mesh = problem.forest.leaf_mesh();
    if (3 * mesh.node_count() == dofs) return solved(std::move(problem));
    if (3 * mesh.node_count() > dofs)
      throw std::runtime_error("no uniform L-shape has " + std::to_string(dofs) + " dofs");
    refine_uniformly(problem.forest);
  }
}

std::unique_ptr<LshapeWorkload> adaptive_workload(int dofs) {
  std::unique_ptr<LshapeWorkload> work = solved(lshape_problem());
  while (work->discretization.dof_count() < dofs) {
    const std::vector<int> marked = mark_maximum(work->eta(), lshape_theta);
    LshapeProblem problem = std::move(work->problem);
    refine_marked(problem.forest, work->discretization.mesh, marked);
    work = solved(std::move(problem));
  }
  if (work->discretization.hanging.hanging_count() == 0)
    throw std::runtime_error("the adaptive L-shape has no hanging nodes");
  return work;
}

}  // namespace

const LshapeWorkload& lshape_workload(bool adaptive, int dofs) {
  static std::map<std::pair<bool, int>, std::unique_ptr<LshapeWorkload>> known;
  std::unique_ptr<LshapeWorkload>& work = known[{adaptive, dofs}];
  if (!work) {
    use_one_thread();
    work = adaptive ? adaptive_workload(dofs) : uniform_workload(dofs);
  }
  return *work;
}

void refine_marked(RefinementForest& forest, const Mesh& mesh, const std::vector<int>& marked) {
  for (const int cell : marked) forest.refine(mesh.forest_cell[cell], {});
}

void count_sizes(benchmark::State& state, const Discretization& d) {
  double held = 0.0;  // the trace of a projector is its rank
  for (const Eigen::Matrix3d& H : d.supports.held) held += H.trace();
  state.counters["free_dofs"] = d.dof_count() - std::round(held);
  state.counters["cells"] = d.mesh.cell_count();
  state.counters["hanging_nodes"] = d.hanging.hanging_count();
  state.counters["blocks"] = d.pattern.block_count();
}

LshapeSystem lshape_system(const LshapeWorkload& work) {
  const Discretization& d = work.discretization;
  LshapeSystem system{assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count())),
                      reduce_forces(d.hanging, work.loads)};
  apply_supports(d.supports, system.A);
  project(d.supports, system.b);
  return system;
}

double relative_residual(const LshapeSystem& system, const Eigen::VectorXd& x) {
  Eigen::VectorXd Ax;
  multiply(system.A, x, Ax);
  return (system.b - Ax).norm() / system.b.norm();
}

}  // namespace finegauge
