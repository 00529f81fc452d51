#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/elasticity/cell_geometry.hpp"
#include "core/mesh/hanging_nodes.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/space/block_matrix.hpp"
#include "core/space/singular_edges.hpp"
#include "core/space/springs.hpp"
#include "core/space/supports.hpp"

namespace finegauge {

/// Where a cell's stiffness goes in the reduced matrix: its reduced nodes (the masters of its corners), and the
/// positions of all their pairs in the pattern. A cell without hanging corners has its corners in order.
struct CellScatter {
  std::vector<int> node_start;          ///< cells + 1, into `nodes`
  std::vector<int> nodes;               ///< reduced numbers
  std::vector<std::size_t> pair_start;  ///< cells + 1, into `positions`
  std::vector<int> positions;           ///< m × m per cell, row a column b at a m + b
  std::vector<int> regular, hanging;    ///< cells without and with a hanging corner, ascending
};

/// Nodes of the boundary at which the stress is known to have no traction (find_free_surface in free_surface.hpp).
struct FreeSurface {
  std::vector<int> nodes;                 ///< ascending
  std::vector<int> face_start;            ///< nodes + 1, into `faces`
  std::vector<std::array<int, 3>> faces;  ///< the free faces of leaves around each node, by their nodes
};

/// All that follows from a mesh, a material, the supports and the springs, and from nothing else, but for what
/// is known of the loads. Built as one value and replaced whole when the forest changes.
struct Discretization {
  Mesh mesh;
  HangingNodes hanging;  ///< T
  Supports supports;     ///< S
  RestShapes shapes;
  BlockPattern pattern;  ///< of the reduced matrix
  CellScatter scatter;
  Springs springs;                          ///< empty where there are none
  std::vector<SingularEdge> singular_edge;  ///< per cell
  FreeSurface free_surface;                 ///< empty until who knows all loads sets it
  bool driven_by_loads = false;             ///< at rest, by no support and no spring; set by solve_static

  int dof_count() const { return 3 * hanging.reduced_count(); }  ///< the paper's count: prescribed ones included
};
Discretization discretize(const RefinementForest& forest, const Material& material,
                          const std::vector<SupportCondition>& supports, int height = 0);
/// Of a `forest.leaf_mesh(...)` of the forest as it is now.
Discretization discretize(const RefinementForest& forest, Mesh mesh, const Material& material,
                          const std::vector<SupportCondition>& supports,
                          const std::vector<SpringSupport>& springs = {});

/// u = T u_m and its adjoint; reduced vectors have 3 × reduced nodes, nodal ones are 3 × nodes.
Eigen::Matrix3Xd expand(const HangingNodes& hanging, const Eigen::VectorXd& reduced);
/// The nodes that do not hang: gather(expand(x)) == x.
Eigen::VectorXd gather(const HangingNodes& hanging, const Eigen::Matrix3Xd& nodal);
/// Tᵀ f: forces at all nodes to forces at those that do not hang.
Eigen::VectorXd reduce_forces(const HangingNodes& hanging, const Eigen::Matrix3Xd& forces);
/// Sets the held directions of a reduced displacement to what the supports prescribe.
void impose(const Supports& supports, Eigen::VectorXd& reduced_displacement);
/// Zeroes the held directions.
void project(const Supports& supports, Eigen::VectorXd& reduced);

/// T as a scalar sparse matrix, 3 n_nodes × 3 n_reduced: for oracles.
Eigen::SparseMatrix<double> interpolation_matrix(const HangingNodes& hanging);

}  // namespace finegauge
