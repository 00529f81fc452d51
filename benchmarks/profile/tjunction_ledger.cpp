#include "benchmarks/profile/tjunction_ledger.hpp"

#include <algorithm>
#include <array>

#include "benchmarks/profile/chain_lengths.hpp"
#include "benchmarks/profile/processor_clock.hpp"
#include "benchmarks/profile/unreduced.hpp"
#include "core/space/assembly.hpp"

namespace finegauge {
TjunctionCounts count_tjunctions(const RefinementForest& forest, const Discretization& d) {
  TjunctionCounts counts;
  counts.cells = d.mesh.cell_count(), counts.nodes = d.mesh.node_count();
  counts.hanging_nodes = d.hanging.hanging_count(), counts.dofs = d.dof_count();
  counts.hanging_cells = static_cast<int>(d.scatter.hanging.size());
  if (d.mesh.shape == CellShape::hexahedron)
    counts.chain_lengths = chain_histogram(chain_lengths(forest, d.mesh, d.hanging));
  counts.longest_chain = d.hanging.longest_chain;
  std::vector<char> is_master(static_cast<std::size_t>(d.hanging.reduced_count()), 0);
  for (int node = 0; node < d.hanging.node_count(); ++node)
    if (d.hanging.hangs(node))
      for (int k = d.hanging.row_start[node]; k < d.hanging.row_start[node + 1]; ++k)
        is_master[static_cast<std::size_t>(d.hanging.master[k])] = 1;
  counts.rows_touched = 3 * static_cast<int>(std::count(is_master.begin(), is_master.end(), 1));
  counts.blocks = d.pattern.block_count();
  counts.nodal_blocks = unreduced(d).pattern.block_count();
  return counts;
}

Json to_json(const TjunctionCounts& c) {
  Json json = {{"cells", c.cells},
               {"nodes", c.nodes},
               {"hanging_nodes", c.hanging_nodes},
               {"hanging_share", c.hanging_share()},
               {"hanging_cells", c.hanging_cells},
               {"dofs", c.dofs},
               {"longest_chain", c.longest_chain},
               {"chain_lengths", c.chain_lengths},
               {"rows_touched", c.rows_touched},
               {"blocks", c.blocks},
               {"blocks_per_row", c.blocks_per_row()},
               {"nodal_blocks", c.nodal_blocks},
               {"nodal_blocks_per_row", c.nodal_blocks_per_row()}};
  if (c.chain_lengths.empty()) {
    json["chain_lengths"] = nullptr;
    json["chain_lengths_reason"] = "counted on hexahedra only";
  }
  return json;
}

Json to_json(const HandlingCost& c) {
  Json json = {{"unknowns", c.unknowns},
               {"matrix_nonzeros", c.matrix_nonzeros},
               {"factor_nonzeros", c.factor_nonzeros},
               {"factor_flops", c.factor_flops},
               {"assemble_ms", c.assemble_ms},
               {"reduce_ms", c.reduce_ms},
               {"symbolic_ms", c.symbolic_ms},
               {"numeric_ms", c.numeric_ms},
               {"solve_ms", c.solve_ms},
               {"total_ms", c.total_ms()},
               {"iterations", c.iterations}};
  if (c.handling == TjunctionHandling::multiplier) json["refinements"] = c.refinements;
  json["difference"] = c.difference;
  json["solved"] = c.solved;
  return json;
}

TjunctionTimes time_tjunctions(const RefinementForest& forest, const Discretization& d, const Eigen::Matrix3Xd& u,
                               int repetitions) {
  Discretization free = unreduced(d);
  free.scatter.regular = d.scatter.hanging;
  BlockMatrix<double> A, A_free;
  A.reset(d.pattern);
  A_free.reset(free.pattern);
  const Eigen::VectorXd x = gather(d.hanging, u), x_free = gather(free.hanging, u);
  // With T and without, in turns.
  enum Part { build, hanging_cells, same_cells, expanded, copied, gathered, summed, parts };
  std::array<std::vector<double>, parts> times;
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    Stopwatch watch(processor_clock());
    const HangingNodes hanging = find_hanging_nodes(forest, d.mesh);
    times[build].push_back(watch.lap());
    assemble_hanging_cells(d, u, A);
    times[hanging_cells].push_back(watch.lap());
    assemble_regular_cells(free, u, A_free);
    times[same_cells].push_back(watch.lap());
    const Eigen::Matrix3Xd nodal = expand(d.hanging, x);
    times[expanded].push_back(watch.lap());
    const Eigen::Matrix3Xd copy = expand(free.hanging, x_free);
    times[copied].push_back(watch.lap());
    const Eigen::VectorXd forces = reduce_forces(d.hanging, u);
    times[gathered].push_back(watch.lap());
    const Eigen::VectorXd sums = reduce_forces(free.hanging, u);
    times[summed].push_back(watch.lap());
  }
  std::array<double, parts> ms;
  std::transform(times.begin(), times.end(), ms.begin(),
                 [](const std::vector<double>& part) { return median_ms(part); });
  return {ms[build], ms[hanging_cells] - ms[same_cells], ms[expanded] - ms[copied], ms[gathered] - ms[summed]};
}

}  // namespace finegauge
