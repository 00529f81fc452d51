#include "core/tissue_step.hpp"

#include <cmath>
#include <map>
#include <stdexcept>

#include "benchmarks/micro/lshape_workload.hpp"
#include "core/space/lumped_mass.hpp"
#include "core/tissue_forces.hpp"

using namespace finegauge;

namespace {

/// The clamped block of 4 × 2 × 2 cm of the phantom, 9 × 4 × 4 cells times `scale`, its column around the axis refined
/// 2×2×2 from x = 0.01 m on, as a needle leaves it; corotational, in mid-swing under gravity.
struct MovingBlock {
  RefinementForest forest;
  TissueProblem problem;
  TissueMesh mesh;
  TissueState state;
};
constexpr double tau = 0.01;  // [s]

MovingBlock build_block(int scale) {
  BoxMeshOptions box;
  box.size = {0.04, 0.02, 0.02};
  box.cells = {9 * scale, 4 * scale, 4 * scale};
  MovingBlock block{RefinementForest(box_mesh(box)), {}, {}, {}};
  const Mesh cells = block.forest.leaf_mesh();
  for (int cell = 0; cell < cells.cell_count(); ++cell) {
    const Eigen::Vector3d centre =
        0.5 * (cells.nodes.col(cells.cells[cell][0]) + cells.nodes.col(cells.cells[cell][7]));
    if (centre.x() > 0.01 && std::abs(centre.y() - 0.01) < 0.005 && std::abs(centre.z() - 0.01) < 0.005)
      block.forest.refine(cells.forest_cell[cell], {{2, 2, 2}});
  }
  block.problem.material.youngs_modulus = 2e4;
  block.problem.material.poisson_ratio = 0.4;
  block.problem.material.kinematics = Kinematics::corotational;
  block.problem.stiffness_damping = 1e-3;
  block.problem.gravity = {0.0, -9.81, 0.0};
  block.problem.supports = {{"x_min", std::nullopt, {}}};
  block.mesh = build_tissue_mesh(block.forest, block.problem);
  const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, block.mesh.d.mesh.node_count());
  block.state = {zero, zero};
  const LinearSolve solve = [](const BlockMatrix<double>& A, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
    return conjugate_gradients(
        A, b, [](const Eigen::VectorXd& r, Eigen::VectorXd& z) { z = r; }, {1e-8, 5000}, x);
  };
  TissueSystem system;
  for (int step = 0; step < 5; ++step)
    if (!step_tissue(block.mesh, block.problem, step * tau, tau, {}, solve, system, block.state).converged)
      throw std::runtime_error("the block's motion was not found");
  return block;
}

const MovingBlock& moving_block(const benchmark::State& state) {
  static std::map<int, MovingBlock> blocks;
  const int scale = static_cast<int>(state.range(0));
  auto found = blocks.find(scale);
  if (found == blocks.end()) found = blocks.emplace(scale, build_block(scale)).first;
  return found->second;
}

constexpr auto block_sizes = [](auto* registered) {
  registered->ArgName("scale")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  for (const int scale : {1, 2, 3}) registered->Arg(scale);
};

/// K, f_int, A and b of a step, supports applied.
void assemble_tissue_step(benchmark::State& state) {
  const MovingBlock& block = moving_block(state);
  TissueSystem system;
  for (auto _ : state) {
    assemble_step(block.mesh, block.problem, block.state, 0.05, tau, system);
    benchmark::ClobberMemory();
  }
  // A w is M w + τ C w + τ² K w, cell by cell without the matrix, in free directions.
  const Discretization& d = block.mesh.d;
  Eigen::VectorXd w = gather(d.hanging, block.state.v), Aw;
  project(d.supports, w);
  multiply(system.A, w, Aw);
  const double beta = block.problem.stiffness_damping;
  Eigen::VectorXd expected = mass_times(block.mesh.mass, w) +
                             (tau * beta + tau * tau) * tissue_forces(d, block.state.u, expand(d.hanging, w)).stiff;
  project(d.supports, expected);
  if (!((Aw - expected).norm() < 1e-10 * expected.norm())) state.SkipWithError("the matrix is not M + τ C + τ² K");
  count_sizes(state, d);
}
BENCHMARK(assemble_tissue_step)->Apply(block_sizes);

void lump_mass(benchmark::State& state) {
  const MovingBlock& block = moving_block(state);
  Eigen::VectorXd mass;
  for (auto _ : state) {
    mass = lumped_mass(block.mesh.d, block.problem.density);
    benchmark::ClobberMemory();
  }
  if (!(std::abs(mass.sum() - 0.016) < 1e-12)) state.SkipWithError("the block's mass is not 16 g");
  count_sizes(state, block.mesh.d);
}
BENCHMARK(lump_mass)->Apply(block_sizes);

/// What the reports of a frame cost: the residual of the implicit step.
void find_equilibrium_error(benchmark::State& state) {
  const MovingBlock& block = moving_block(state);
  const Eigen::VectorXd v = gather(block.mesh.d.hanging, block.state.v);
  double error = 0.0;
  for (auto _ : state) {
    error = out_of_balance(block.mesh, block.problem, block.state, v, {}, tau).error();
    benchmark::DoNotOptimize(error);
  }
  if (!(error > 0.0 && error < 10.0)) state.SkipWithError("not an error of a moving block");
  count_sizes(state, block.mesh.d);
}
BENCHMARK(find_equilibrium_error)->Apply(block_sizes);

/// A needle drawn out: half of the refined cells go. Sizes are those of the finer mesh; without the mesh's own making.
void transfer_to_coarsened(benchmark::State& state) {
  const MovingBlock& block = moving_block(state);
  RefinementForest forest = block.forest;
  int coarsened = 0;
  for (int handle = 0; handle < static_cast<int>(forest.base().cells.size()); handle += 2)
    if (forest.can_coarsen(handle)) {
      forest.coarsen(handle);
      ++coarsened;
    }
  const TissueMesh coarse = build_tissue_mesh(forest, block.problem);
  TissueState result;
  for (auto _ : state) {
    result = transfer_state(block.mesh, block.state, coarse, nullptr);
    benchmark::ClobberMemory();
  }
  TransferLedger ledger;
  (void)transfer_state(block.mesh, block.state, coarse, &ledger);
  if (!(coarsened > 0 && ledger.moved > 0 && ledger.momentum_change < 1e-13 && ledger.kinetic_change < 0.0))
    state.SkipWithError("the transfer did not keep the momentum");
  count_sizes(state, block.mesh.d);
  state.counters["moved_nodes"] = ledger.moved;
}
BENCHMARK(transfer_to_coarsened)->Apply(block_sizes);

void transfer_to_finer(benchmark::State& state) {
  const MovingBlock& block = moving_block(state);
  RefinementForest forest = block.forest;
  int refined = 0;
  for (int handle = 0; handle < static_cast<int>(forest.base().cells.size()); handle += 16)
    if (forest.is_leaf(handle)) {
      forest.refine(handle, {{2, 2, 2}});
      ++refined;
    }
  const TissueMesh fine = build_tissue_mesh(forest, block.problem);
  TissueState result;
  for (auto _ : state) {
    result = transfer_state(block.mesh, block.state, fine, nullptr);
    benchmark::ClobberMemory();
  }
  TransferLedger ledger;
  (void)transfer_state(block.mesh, block.state, fine, &ledger);
  if (!(refined > 0 && ledger.moved == 0 && ledger.momentum_change < 1e-13))
    state.SkipWithError("the transfer did not keep the momentum");
  count_sizes(state, block.mesh.d);
}
BENCHMARK(transfer_to_finer)->Apply(block_sizes);

}  // namespace
