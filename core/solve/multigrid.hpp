#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/solve/direct_solver.hpp"
#include "core/solve/solve_report.hpp"
#include "core/space/assembly.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Values at a mesh's nodes that do not hang from those of the next coarser mesh: rows of node weights.
struct Prolongation {
  std::vector<int> row_start;
  std::vector<int> column;
  std::vector<float> weight;
};

/// The coarser meshes below a discretization, finest first, and the interpolations between them. Their spaces are
/// nested, but where T gives up a bend (hanging_nodes.hpp). Follows from the forest as the discretization does, and is
/// rebuilt with it.
struct MeshHierarchy {
  std::vector<Discretization> coarse;
  std::vector<Prolongation>
      prolongations;  ///< [0] from coarse[0] to the fine mesh, [l] from coarse[l] to coarse[l - 1]
};
struct HierarchyOptions {
  int smallest = 50;       ///< reduced nodes at which the direct solve takes over; else it does on the base mesh, whose
                           ///< factor a FactorCache can keep while all finer meshes change
  double reduction = 0.6;  ///< a level is kept when it has at most this share of the next finer one's cells
};
MeshHierarchy build_hierarchy(const RefinementForest& forest, const Discretization& fine,
                              const std::vector<SupportCondition>& supports, const HierarchyOptions& options = {});

/// V-cycle on the hierarchy: one forward block Gauss-Seidel sweep down, one backward sweep up, which makes it
/// symmetric; a direct solve on the coarsest mesh. Single precision but for that solve: it only preconditions. Coarse
/// matrices are assembled on the coarse meshes, with rotations from their own corners' displacements.
/// Borrows the discretization, the hierarchy and the pattern of the matrix.
class Multigrid {
 public:
  /// `factors` may bring the factor of the coarsest matrix along from an earlier mesh.
  /// `fine_matrix` with supports applied; u the nodal displacement of the fine mesh at which rotations are frozen.
  Multigrid(const Discretization& fine, const BlockMatrix<double>& fine_matrix, const Eigen::Matrix3Xd& u,
            const MeshHierarchy& hierarchy, FactorCache& factors);
  ~Multigrid();
  Multigrid(Multigrid&&) noexcept;

  /// False when the coarsest matrix could not be factored (DirectSolver::factored): mostly, the body is not held.
  bool usable() const;
  /// z = approximately A⁻¹ r.
  void apply(const Eigen::VectorXd& r, Eigen::VectorXd& z);

 private:
  struct Level;
  std::vector<std::unique_ptr<Level>> levels_;  ///< finest first
  std::shared_ptr<const DirectSolver> coarsest_;
};

}  // namespace finegauge
