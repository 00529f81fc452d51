#include "verification/studies/pollution.hpp"

#include <algorithm>
#include <stdexcept>

#include "verification/studies/estimator_rungs.hpp"

namespace finegauge {

namespace {

double shown(const LadderRung& rung, const StaticSolution& solution) {
  constexpr double farther_than = 0.3;
  const Mesh& mesh = solution.discretization.mesh;
  const ErrorEstimate spr = estimate_error(solution.discretization, solution.equilibrium.u, Estimator::spr);
  const TrueError truth = true_error_of(rung, solution, spr);
  double estimated = 0.0, exact = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (int c = 0; c < 4; ++c) centre += mesh.nodes.col(mesh.cells[cell][c]) / 4.0;
    if (centre.head<2>().norm() < farther_than) continue;
    estimated += spr.eta[cell] * spr.eta[cell];
    exact += truth.cell[cell] * truth.cell[cell];
  }
  return estimated / exact;
}

}  // namespace

SquaresShown squares_shown_far_from_tip() {
  std::vector<LadderRung> rungs = tetrahedra_rungs();
  const auto crack = std::ranges::find(rungs, "crack", &LadderRung::name);
  if (crack == rungs.end()) throw std::logic_error("squares_shown_far_from_tip: the ladder has no crack");
  StaticSolution solution = solve(*crack);
  const double of_solution = shown(*crack, solution);
  const Mesh& mesh = solution.discretization.mesh;
  for (int node = 0; node < mesh.node_count(); ++node)
    solution.equilibrium.u.col(node) = crack->exact.displacement(mesh.nodes.col(node));
  return {shown(*crack, solution), of_solution};
}

}  // namespace finegauge
