#pragma once

#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <span>
#include <vector>

#include "benchmarks/paper/lshape_problem.hpp"
#include "core/adapt/error_estimate.hpp"
#include "core/equilibrium.hpp"

namespace finegauge {

/// The L-shape on one of its meshes, solved: what every stage of the static loop meets. Built once for each mesh and
/// kept, so that no benchmark pays for it. The first one built limits BLAS and OpenMP to one thread.
struct LshapeWorkload {
  LshapeProblem problem;
  Discretization discretization;
  MeshHierarchy hierarchy;
  Eigen::Matrix3Xd loads;  ///< [N]
  Equilibrium solution;    ///< to a relative residual of 1e-8
  ErrorEstimate estimate;

  std::span<const double> eta() const { return {estimate.eta.data(), static_cast<std::size_t>(estimate.eta.size())}; }
};

/// Uniform: the mesh with exactly `dofs`, 975, 6,075 or 42,483. Adaptive: the paper's loop (2×2×2, maximum strategy,
/// theta = 0.3) until there are at least `dofs`. Throws std::runtime_error when the mesh or its solution does not come
/// about; the benchmark then fails.
const LshapeWorkload& lshape_workload(bool adaptive, int dofs);
/// The workload that a benchmark's two arguments name.
inline const LshapeWorkload& lshape_workload(const benchmark::State& state) {
  return lshape_workload(state.range(0) != 0, static_cast<int>(state.range(1)));
}

/// BLAS and OpenMP, where they are there. A benchmark that brings its own work calls it before it builds that.
void use_one_thread();

/// Refines the marked leaves 2×2×2.
void refine_marked(RefinementForest& forest, const Mesh& mesh, const std::vector<int>& marked);
inline constexpr double lshape_theta = 0.3;  ///< the paper's marking fraction

/// The meshes of every benchmark: three uniform, two adaptive. Processor time is that of all threads, so that one that
/// should not be there shows.
inline constexpr auto lshape_meshes = [](auto* registered) {
  registered->ArgNames({"adaptive", "dofs"})->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  for (const int dofs : {975, 6075, 42483}) registered->Args({0, dofs});
  for (const int dofs : {5000, 30000}) registered->Args({1, dofs});
};
/// The adaptive ones alone, for what uniform meshes do not have.
inline constexpr auto lshape_adaptive_meshes = [](auto* registered) {
  registered->ArgNames({"adaptive", "dofs"})->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  for (const int dofs : {5000, 30000}) registered->Args({1, dofs});
};

/// The sizes that stand beside every time: free dofs (prescribed ones left out), cells, hanging nodes, 3 × 3 blocks of
/// the reduced matrix.
void count_sizes(benchmark::State& state, const Discretization& d);
/// Assembled stiffness with supports applied, and the load of its free directions.
struct LshapeSystem {
  BlockMatrix<double> A;
  Eigen::VectorXd b;
};
LshapeSystem lshape_system(const LshapeWorkload& work);
/// ‖b - A x‖ / ‖b‖.
double relative_residual(const LshapeSystem& system, const Eigen::VectorXd& x);

}  // namespace finegauge
