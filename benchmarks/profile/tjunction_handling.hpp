#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/mesh/refinement_forest.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// How the system of a mesh with hanging nodes is brought to a conforming field.
enum class TjunctionHandling {
  elementwise,       ///< each cell's stiffness is reduced as it is assembled: what the core does
  explicit_product,  ///< the matrix of all nodes A is assembled, and Tᵀ A T formed by two sparse products
  multiplier,        ///< A stays; a multiplier for each component of each hanging node holds it on its masters
  ignored  ///< A alone: hanging nodes are nodes of their own and the field gapes. No solution of the problem, but
           ///< the cost of a mesh of as many nodes of which none hangs
};
std::string to_string(TjunctionHandling handling);
inline constexpr TjunctionHandling tjunction_handlings[] = {TjunctionHandling::elementwise,
                                                            TjunctionHandling::explicit_product,
                                                            TjunctionHandling::multiplier, TjunctionHandling::ignored};

/// One system of equations, from the displacement to the displacement. Times in milliseconds of the processor
/// (processor_clock.hpp), medians.
struct HandlingCost {
  TjunctionHandling handling = TjunctionHandling::elementwise;
  int unknowns = 0;
  double matrix_nonzeros = 0.0, factor_nonzeros = 0.0;
  double factor_flops = 0.0;  ///< of a Cholesky factor of that pattern
  double assemble_ms = 0.0;   ///< of the cells as if no corner of theirs hung, supports applied
  double reduce_ms = 0.0;     ///< elementwise: what hanging corners add to the assembly. Explicit: both products.
                              ///< Multiplier: the values' way into the larger matrix
  double symbolic_ms = 0.0, numeric_ms = 0.0;  ///< of the factor (sparse_factor.hpp)
  double solve_ms = 0.0;                       ///< with the factor, and every node from the nodes that do not hang
  int refinements = 0;      ///< multiplier: solves after the first, since its factor is that of a shifted matrix
  int iterations = 0;       ///< of conjugate gradients, or of MINRES for the multiplier, without a preconditioner
  double difference = 0.0;  ///< of u from that of `elementwise`, over its norm
  bool solved = true;
  Eigen::Matrix3Xd u;  ///< nodal displacement [m]

  double matrix_ms() const { return assemble_ms + reduce_ms; }
  double total_ms() const { return matrix_ms() + symbolic_ms + numeric_ms + solve_ms; }
};

struct HandlingOptions {
  int repetitions = 3;     ///< the handlings take turns
  bool iterate = true;     ///< whether the iterations are counted
  double residual = 1e-8;  ///< relative, of the iterations
  int most_iterations = 50000;
};

/// Costs of the handlings, in the order given, of one mesh: stiffness with rotations frozen at `at` [m, 3 × nodes],
/// loads [N, nodal], held directions at zero. Precondition: what the supports leave of the body has no rigid motion.
std::vector<HandlingCost> compare_handlings(const Discretization& d, const Eigen::Matrix3Xd& at,
                                            const Eigen::Matrix3Xd& loads, const std::vector<TjunctionHandling>& which,
                                            const HandlingOptions& options);

}  // namespace finegauge
