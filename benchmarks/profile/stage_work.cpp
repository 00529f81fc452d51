#include "benchmarks/profile/stage_work.hpp"

#include <cmath>

#include "benchmarks/profile/sparse_factor.hpp"
#include "core/space/assembly.hpp"

namespace finegauge {
namespace {

constexpr double block_bytes = 9 * sizeof(double), index_bytes = sizeof(int);
constexpr double corners = 8, corner_pairs = corners * corners;
// A product of two 3 × 3 matrices: 27 multiplications, 18 additions. Of one with a vector: 9 and 6, and 3 more
// additions where it is added to another.
constexpr double product_flops = 45, vector_product_flops = 15, block_flops = 18;

/// R K (Rᵀ x - X) of a cell: two rotations of its eight corners, the difference, and the 24 × 24 product.
constexpr double cell_force_flops = 2 * corners * vector_product_flops + 3 * corners + 24 * (24 + 23);

}  // namespace

WorkSizes work_sizes(const Discretization& d, bool with_factor) {
  WorkSizes sizes;
  sizes.cells = d.mesh.cell_count();
  sizes.blocks = d.pattern.block_count();
  sizes.rows = d.pattern.size();
  sizes.regular_cells = static_cast<double>(d.scatter.regular.size());
  sizes.pairs = static_cast<double>(d.scatter.positions.size());
  sizes.corotational = d.shapes.material().kinematics == Kinematics::corotational;
  for (const int cell : d.scatter.hanging) {
    double entries = 0.0;
    for (int c = 0; c < corner_count(d.mesh.shape); ++c) {
      const int node = d.mesh.cells[cell][c];
      entries += d.hanging.row_start[node + 1] - d.hanging.row_start[node];
    }
    const double nodes = d.scatter.node_start[cell + 1] - d.scatter.node_start[cell];
    sizes.hanging_entries += entries;
    sizes.hanging_row_entries += entries * nodes;
    sizes.hanging_pairs += nodes * nodes;
  }
  if (with_factor) {
    BlockMatrix<double> pattern;  // the values play no part in the analysis
    pattern.reset(d.pattern);
    for (double& value : pattern.values) value = 1.0;
    SparseFactor factor(to_sparse(pattern), SparseFactor::Kind::positive_definite);
    factor.analyze();
    sizes.factor_nonzeros = factor.factor_nonzeros();
    sizes.factor_flops = factor.factor_flops();
  }
  return sizes;
}

StageWork static_assembly_work(const WorkSizes& s) {
  StageWork work;
  const double rotated = s.corotational ? 2 * product_flops * corner_pairs * s.cells : 0.0;
  const double summed = 9 * corner_pairs * s.regular_cells + 9 * s.hanging_pairs;
  // K T: a master's weight times three columns of 24, added; Tᵀ (K T): times three rows of the cell's reduced nodes.
  const double reduced = 2 * 24 * 3 * s.hanging_entries + 2 * 3 * 3 * s.hanging_row_entries;
  work.flops = rotated + summed + reduced;
  // Set to zero, and each block read and written once (cells that share it find it in a cache); the positions.
  work.bytes = 3 * block_bytes * s.blocks + index_bytes * s.pairs;
  return work;
}

StageWork assembly_work(const WorkSizes& s) {
  StageWork work = static_assembly_work(s);
  work.flops += block_flops * s.blocks  // K v
                + 9 * s.blocks          // A = (τ β + τ²) K
                + cell_force_flops * s.cells;
  work.bytes += (block_bytes + index_bytes) * s.blocks + 2 * block_bytes * s.blocks;
  return work;
}

StageWork solve_work(const WorkSizes& s, const SolveCounts& counts) {
  const double n = 3 * s.rows;
  StageWork iteration;
  iteration.flops = block_flops * s.blocks + 10 * n;  // two dot products, three vector updates
  iteration.bytes = (block_bytes + index_bytes) * s.blocks + 8 * sizeof(double) * n;
  StageWork solve;  // with L and with Lᵀ
  solve.flops = 4 * s.factor_nonzeros;
  solve.bytes = 2 * sizeof(double) * s.factor_nonzeros;
  StageWork work;
  const double solves = counts.columns + (counts.with_factor ? counts.iterations : 0.0);
  work.flops = counts.iterations * iteration.flops + solves * solve.flops + counts.factorizations * s.factor_flops;
  // Three columns of a point share a pass over the factor.
  work.bytes = counts.iterations * iteration.bytes +
               (counts.columns / 3 + (counts.with_factor ? counts.iterations : 0.0)) * solve.bytes +
               counts.factorizations * (0.5 * block_bytes * s.blocks + sizeof(double) * s.factor_nonzeros);
  return work;
}

StageWork update_work(const WorkSizes& s, int linearizations) {
  // Elastic and damping force of each cell; its energy: as a force but for the way back.
  const double passes = 2.0 * (linearizations + 1);
  const double energy = corners * vector_product_flops + 3 * corners + 24 * (24 + 23) + 47;
  StageWork work;
  work.flops = (passes * cell_force_flops + energy) * s.cells;
  work.bytes = (linearizations + 2) * (corners * index_bytes * s.cells + 2 * 3 * sizeof(double) * s.rows);
  return work;
}

StageWork cycle_work(const Discretization& fine, const MeshHierarchy& hierarchy) {
  StageWork work;
  for (std::size_t level = 0; level < hierarchy.coarse.size(); ++level) {
    const BlockPattern& pattern = level == 0 ? fine.pattern : hierarchy.coarse[level - 1].pattern;
    const double weights = static_cast<double>(hierarchy.prolongations[level].weight.size());
    // Forward sweep: lower triangle; residual: upper; backward sweep: both; a row's diagonal block twice.
    work.flops += 2 * block_flops * pattern.block_count() + 2 * 2 * 3 * weights;
    work.bytes +=
        2 * (9 * sizeof(float) + index_bytes) * pattern.block_count() + 2 * (sizeof(float) + index_bytes) * weights;
  }
  const WorkSizes coarsest = work_sizes(hierarchy.coarse.empty() ? fine : hierarchy.coarse.back(), true);
  work.flops += 4 * coarsest.factor_nonzeros;
  work.bytes += 2 * sizeof(double) * coarsest.factor_nonzeros;
  return work;
}

std::string counted_work(const std::string& stage) {
  if (stage == "assemble")
    return "rotated cell stiffness, its sums and reduction, K v, internal forces; not the rotations, supports, loads";
  if (stage == "reduce") return "with assemble, which has both";
  if (stage == "solve")
    return "iterations (product, preconditioner, vectors), factors and columns of the points; not first and last "
           "residuals, the needle and the contact rows";
  if (stage == "update") return "forces and energies of the cells; not the rotations";
  return {};
}

std::string uncounted_work(const std::string& stage) {
  if (stage == "needle" || stage == "contact") return "small dense blocks of a needle: microseconds, not counted";
  if (stage == "estimate") return "patches and their least squares differ from node to node: no formula from counts";
  if (stage == "mark") return "comparisons and sorting: no floating-point work to speak of";
  if (stage == "topology") return "integers and tables: no floating-point work to speak of";
  if (stage == "transfer") return "depends on which cells changed: no formula from counts";
  if (stage == "reduce") return "counted with assemble";
  if (stage == "other") return "what no stage has";
  return "counted from the second frame on, whose mesh is known";
}

}  // namespace finegauge
