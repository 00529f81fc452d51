#pragma once

#include <vector>

#include "benchmarks/profile/tjunction_handling.hpp"
#include "benchmarks/program/result_document.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// What hanging nodes are in one mesh, by exact counts.
struct TjunctionCounts {
  int cells = 0, nodes = 0, hanging_nodes = 0, dofs = 0;
  int hanging_cells = 0;           ///< cells with a hanging corner
  std::vector<int> chain_lengths;  ///< entry k: nodes with chains of k levels (chain_lengths.hpp); empty: tetrahedra
  int longest_chain = 0;           ///< as T says
  int rows_touched = 0;            ///< rows of the reduced matrix of nodes that are masters: 3 × those
  double blocks = 0, nodal_blocks = 0;  ///< 3 × 3, of the reduced matrix and of the matrix of all nodes

  double hanging_share() const { return nodes > 0 ? static_cast<double>(hanging_nodes) / nodes : 0.0; }
  double blocks_per_row() const { return dofs > 0 ? 3.0 * blocks / dofs : 0.0; }
  double nodal_blocks_per_row() const { return nodes > 0 ? nodal_blocks / nodes : 0.0; }
};
TjunctionCounts count_tjunctions(const RefinementForest& forest, const Discretization& d);
Json to_json(const TjunctionCounts& counts);

/// A cost as the result shows it; of multipliers with their refinements.
Json to_json(const HandlingCost& cost);

/// Milliseconds of the processor, medians, of what hanging nodes cost on a mesh.
struct TjunctionTimes {
  double build_ms = 0.0;   ///< T: the search for hanging nodes and their elimination
  double reduce_ms = 0.0;  ///< one assembly: cells with hanging corners, less the same cells without T
  double expand_ms = 0.0;  ///< one field to all nodes, less its copy
  double gather_ms = 0.0;  ///< one vector of forces to the masters, less its copy
};
/// `u`: rotations are frozen there [m, 3 × nodes].
TjunctionTimes time_tjunctions(const RefinementForest& forest, const Discretization& d, const Eigen::Matrix3Xd& u,
                               int repetitions);

}  // namespace finegauge
