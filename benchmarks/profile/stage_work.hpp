#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "benchmarks/program/motion_run.hpp"
#include "core/scene/scene.hpp"
#include "core/solve/multigrid.hpp"

namespace finegauge {

// Flops and bytes of stages by formulas from exact counts: cells, 3 × 3 blocks of the matrix, nonzeros of the factor,
// iterations. A flop is an addition, multiplication or division of two numbers; a multiply-add counts as two. Bytes are
// those that a stage has to read and write if each large array comes from memory once for each pass over it and vectors
// of the cells stay in the caches: compulsory traffic, not what a cache misses. Each formula leaves out what it names,
// so that all of it are lower bounds.

struct StageWork {
  double flops = 0.0, bytes = 0.0;
  StageWork& operator+=(const StageWork& other) {
    flops += other.flops, bytes += other.bytes;
    return *this;
  }
};

/// Sizes of a mesh that formulas take, found once for each mesh.
struct WorkSizes {
  double cells = 0, blocks = 0, rows = 0;  ///< rows of blocks: nodes that do not hang
  double hanging_entries = 0;  ///< Σ over the corners of cells with hanging corners of the masters, times their nodes
  double hanging_row_entries = 0;  ///< the same times the cell's reduced nodes
  double hanging_pairs = 0;        ///< Σ over those cells of the square of their reduced nodes
  double regular_cells = 0;
  double pairs = 0;                              ///< all cells
  double factor_nonzeros = 0, factor_flops = 0;  ///< of a Cholesky factor of the whole matrix; zero when not asked for
  bool corotational = false;
};
WorkSizes work_sizes(const Discretization& d, bool with_factor);

/// K, K v and the internal forces of one linearization: rotated blocks R K Rᵀ, their sums, reduction, and the passes
/// over the matrix. Left out: the rotations themselves (their iterations are not counted), supports, loads. Hexahedra
/// that share their rest shapes; others compute their stiffness on the way, which is left out too.
StageWork assembly_work(const WorkSizes& sizes);
/// Static: one assembly without K v and forces.
StageWork static_assembly_work(const WorkSizes& sizes);
/// Conjugate gradients and what precondions them. Left out: first and last residuals, constraint rows.
struct SolveCounts {
  double iterations = 0, factorizations = 0, columns = 0;  ///< columns: right sides solved for with the factor beside
  bool with_factor = true;                                 ///< each iteration solves with the factor
};
StageWork solve_work(const WorkSizes& sizes, const SolveCounts& counts);
/// Forces of all cells for the equilibrium error of each linearization, for the ledger of energies, and the elastic
/// energy. Left out: the rotations, vectors.
StageWork update_work(const WorkSizes& sizes, int linearizations);

/// One V-cycle (core/solve/multigrid.cpp): sweeps, residual and transfer on each level but the coarsest, whose factor
/// solves.
StageWork cycle_work(const Discretization& fine, const MeshHierarchy& hierarchy);

/// What is counted, in words for the result; empty for stages that have no formula.
std::string counted_work(const std::string& stage);
/// Why a stage has none.
std::string uncounted_work(const std::string& stage);

}  // namespace finegauge
