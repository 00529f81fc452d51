#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "core/solve/direct_solver.hpp"
#include "core/tissue_step.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

namespace finegauge {

/// Solves by CHOLMOD with one step of refinement, so that what is left is the round-off of the residual; the factor is
/// kept while the matrix is the same to the last bit.
inline LinearSolve direct_linear_solve(FactorCache& factors) {
  return [&factors](const BlockMatrix<double>& A, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
    SolveReport report;
    const auto solver = factors.factor(A);
    if (!solver->factored()) return report;
    Eigen::VectorXd Ax;
    x = solver->solve(b);
    multiply(A, x, Ax);
    x += solver->solve(b - Ax);
    multiply(A, x, Ax);
    const double norm = b.norm();
    report.relative_residual = norm > 0.0 ? (b - Ax).norm() / norm : 0.0;
    report.converged = report.relative_residual < 1e-9;
    report.iterations = 1;
    return report;
  };
}

/// A soft body; supports and the rest are up to the test.
inline TissueProblem soft_problem(Kinematics kinematics = Kinematics::linear) {
  TissueProblem problem;
  problem.material.youngs_modulus = 1e4;
  problem.material.poisson_ratio = 0.4;
  problem.material.kinematics = kinematics;
  problem.density = 1000.0;
  return problem;
}

/// Of a support; starts at rest.
inline double swing(double t) { return 0.5 * (1.0 - std::cos(20.0 * t)); }

struct RandomBody {
  CellShape shape = CellShape::hexahedron;
  std::vector<RefinementTemplate> templates = {{{2, 2, 2}}, {{3, 3, 3}}, {{2, 3, 3}}};
  int refinements = 6;
  int max_depth = 2;
  int max_leaves = 300;
};
/// A unit box of distorted, scrambled cells (2 × 2 × 1 hexahedra or six tetrahedra), refined at random; its volume
/// is 1.
inline RefinementForest random_body(const RandomBody& options, std::mt19937& generator) {
  BoxMeshOptions box;
  box.cells = options.shape == CellShape::hexahedron ? std::array{2, 2, 1} : std::array{1, 1, 1};
  box.shape = options.shape;
  RefinementForest forest(scrambled(distorted_box(box, 0.15, generator), generator));
  const std::vector<RefinementTemplate> red = {{{2, 2, 2}}};
  refine_randomly(forest,
                  {options.shape == CellShape::hexahedron ? options.templates : red, options.refinements,
                   options.max_depth, options.max_leaves},
                  generator);
  return forest;
}

/// A conforming field with random values at the nodes that do not hang.
inline Eigen::Matrix3Xd random_field(const Discretization& d, double size, std::mt19937& generator) {
  Eigen::VectorXd reduced(d.dof_count());
  for (double& value : reduced) value = size * random_number(generator);
  return expand(d.hanging, reduced);
}

inline TissueState state_at_rest(const TissueMesh& mesh) {
  const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, mesh.d.mesh.node_count());
  return {zero, zero};
}

}  // namespace finegauge
