#include <Eigen/Geometry>
#include <numbers>

#include "benchmarks/micro/lshape_workload.hpp"

using namespace finegauge;

namespace {

/// The mesh with a corotational material, bent and then turned by 40 degrees: no cell's rotation is the identity.
struct TurnedLshape {
  Discretization d;
  Eigen::Matrix3d Q;
  Eigen::Matrix3Xd u;         ///< Q (X + u) - X
  Eigen::Matrix3Xd unturned;  ///< before the turn
};
TurnedLshape turned(const LshapeWorkload& work) {
  Material material = work.problem.material;
  material.kinematics = Kinematics::corotational;
  TurnedLshape result;
  result.d = discretize(work.problem.forest, material, work.problem.supports);
  result.Q = Eigen::AngleAxisd(40.0 * std::numbers::pi / 180.0, Eigen::Vector3d(1.0, 2.0, -1.0).normalized());
  result.unturned = 20.0 * work.solution.u;  // large: a few tenths of the edge
  result.u = result.Q * (result.d.mesh.nodes + result.unturned) - result.d.mesh.nodes;
  return result;
}

/// Forces turn with the body.
bool is_objective(const TurnedLshape& lshape) {
  const Eigen::Matrix3Xd there = internal_forces(lshape.d, lshape.u);
  const Eigen::Matrix3Xd here = lshape.Q * internal_forces(lshape.d, lshape.unturned);
  return here.norm() > 0.0 && (there - here).norm() < 1e-9 * here.norm();
}

/// A polar decomposition per cell and R K Rᵀ: against `assemble`, what corotation costs.
void assemble_corotational(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const TurnedLshape lshape = turned(work);
  BlockMatrix<double> A;
  for (auto _ : state) {
    A.reset(lshape.d.pattern);
    assemble_regular_cells(lshape.d, lshape.u, A);
    assemble_hanging_cells(lshape.d, lshape.u, A);
    benchmark::ClobberMemory();
  }
  if (!is_objective(lshape)) state.SkipWithError("the internal forces do not turn with the body");
  count_sizes(state, lshape.d);
}
BENCHMARK(assemble_corotational)->Apply(lshape_meshes);

void corotational_forces(benchmark::State& state) {
  const LshapeWorkload& work = lshape_workload(state);
  const TurnedLshape lshape = turned(work);
  for (auto _ : state) benchmark::DoNotOptimize(internal_forces(lshape.d, lshape.u));
  if (!is_objective(lshape)) state.SkipWithError("the internal forces do not turn with the body");
  count_sizes(state, lshape.d);
}
BENCHMARK(corotational_forces)->Apply(lshape_meshes);

}  // namespace
