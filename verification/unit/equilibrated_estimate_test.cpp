#include "core/equilibrated_estimate.hpp"

#include <numbers>

#include "verification/support/catch.hpp"
#include "verification/support/exact_field.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

StaticSolution solved(const RefinementForest& forest, const StaticProblem& problem) {
  FactorCache factors;
  StaticSolution solution = solve_static(forest, problem, nullptr, factors);
  REQUIRE(solution.equilibrium.converged);
  return solution;
}

EquilibratedEstimate estimate(const RefinementForest& forest, const StaticProblem& problem,
                              const StaticSolution& solution, int degree = 2) {
  EquilibratedOptions options;
  options.degree = degree;
  return estimate_error_equilibrated(forest, solution.discretization, problem, solution.equilibrium.u,
                                     solution.estimate, options);
}

BaseMesh cube(int n) {
  BoxMeshOptions options;
  options.cells = {n, n, n};
  return box_mesh(options);
}

}  // namespace

TEST_CASE("a solution that the cells represent has no distance from equilibrium, on any mesh", "[equilibrated]") {
  std::mt19937 generator(11);
  BoxMeshOptions options;
  options.cells = {2, 2, 2};
  RefinementForest forest(scrambled(distorted_box(options, 0.1, generator), generator));
  const std::vector<RefinementTemplate> templates = all_templates();
  refine_randomly(forest, {templates, 5, 2, 400}, generator);
  StaticProblem problem;
  problem.solver.linear.relative_residual = 1e-13;
  Eigen::Matrix3d gradient;
  gradient << 1e-3, 2e-4, 0.0, 3e-4, -5e-4, 1e-4, 0.0, 2e-4, 7e-4;
  for (const char* surface : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
    problem.supports.push_back(
        {surface, std::nullopt, [=](const Eigen::Vector3d& X) { return Eigen::Vector3d(gradient * X); }});
  const StaticSolution solution = solved(forest, problem);
  REQUIRE(solution.discretization.hanging.hanging_count() > 10);
  const EquilibratedEstimate found = estimate(forest, problem, solution);
  REQUIRE(found.exists());
  // Constant stress: SPR recovers it, tractions are in equilibrium, and nothing is left but the solver's residual.
  CHECK(found.relative < 1e-9);
}

TEST_CASE("the distance from equilibrium is above the true error and below twice it, on meshes that hang",
          "[equilibrated]") {
  const int seed = GENERATE(1, 2, 3);
  CAPTURE(seed);
  std::mt19937 generator(static_cast<unsigned>(seed));
  RefinementForest forest(cube(3));
  const std::vector<RefinementTemplate> templates = all_templates();
  refine_randomly(forest, {templates, 6, 2, 400}, generator);
  StaticProblem problem;
  const ExactField exact = exact_field(smooth_solution(), problem.material);
  problem.body = exact.body;
  for (const char* surface : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
    problem.supports.push_back({surface, std::nullopt, exact.displacement});
  const StaticSolution solution = solved(forest, problem);
  REQUIRE(solution.discretization.hanging.hanging_count() > 10);
  const TrueError truth =
      true_error(solution.discretization, exact, solution.equilibrium.u, solution.estimate.nodal_stress);
  const EquilibratedEstimate two = estimate(forest, problem, solution, 2),
                             three = estimate(forest, problem, solution, 3);
  CHECK(two.total > truth.total);
  CHECK(two.total < 2.0 * truth.total);
  CHECK(three.total > two.total);              // richer local solutions lose less
  CHECK(three.total < 1.1 * two.total);        // and two was nearly all
  CHECK(two.imbalance < 1e-12);                // the cells do stand under their tractions
  CHECK(two.correction > 0.05 * truth.total);  // and would not have without the change
}

TEST_CASE("what the balance does not know is refused in words", "[equilibrated]") {
  RefinementForest forest(cube(2));
  StaticProblem problem;
  problem.supports.push_back({"x_min", std::nullopt, {}});
  problem.loads.push_back({"x_max", LoadKind::total_by_node, {1.0, 0.0, 0.0}});
  CHECK_THAT(estimate(forest, problem, solved(forest, problem)).why_not, ContainsSubstring("shared by nodes"));
  problem.loads[0].kind = LoadKind::total_by_area;
  CHECK(estimate(forest, problem, solved(forest, problem)).exists());
  problem.material.kinematics = Kinematics::corotational;
  CHECK_THAT(estimate(forest, problem, solved(forest, problem)).why_not, ContainsSubstring("linear kinematics"));
  problem.material.kinematics = Kinematics::linear;

  BoxMeshOptions options;
  options.shape = CellShape::tetrahedron;
  options.cells = {2, 2, 2};
  const RefinementForest tetrahedra(box_mesh(options));
  const EquilibratedEstimate none = estimate(tetrahedra, problem, solved(tetrahedra, problem));
  CHECK_THAT(none.why_not, ContainsSubstring("hexahedra"));
  CHECK(none.eta.size() == 0);
}
