#include "core/static_step.hpp"

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

bool driven_by_loads(const StaticProblem& problem) {
  BoxMeshOptions options;
  options.cells = {2, 2, 2};
  options.shape = CellShape::tetrahedron;
  FactorCache factors;
  return solve_static(RefinementForest(box_mesh(options)), problem, nullptr, factors).discretization.driven_by_loads;
}

}  // namespace

TEST_CASE("loads alone drive a body where no support moves it and no spring holds it", "[static]") {
  StaticProblem problem;
  problem.supports = {{"z_min", std::nullopt, {}}};
  problem.loads = {{"z_max", LoadKind::traction, {0.0, 0.1, 1.0}}};
  CHECK(driven_by_loads(problem));

  StaticProblem resting = problem;
  resting.supports.push_back({"x_min", Eigen::Vector3d(Eigen::Vector3d::UnitX()),
                              [](const Eigen::Vector3d&) -> Eigen::Vector3d { return Eigen::Vector3d::UnitY(); }});
  CHECK(driven_by_loads(resting));  // along its face alone, which the roller leaves free

  StaticProblem moved = problem;
  moved.supports.push_back(
      {"x_min", Eigen::Vector3d(Eigen::Vector3d::UnitX()), [](const Eigen::Vector3d& X) -> Eigen::Vector3d {
         return {1e-4 * X.y(), 0.0, 0.0};
       }});
  CHECK_FALSE(driven_by_loads(moved));

  // Round-off of a displacement of zero is none.
  StaticProblem nearly = problem;
  nearly.supports.push_back(
      {"x_min", Eigen::Vector3d(Eigen::Vector3d::UnitX()), [](const Eigen::Vector3d& X) -> Eigen::Vector3d {
         return {1e-18 * X.y(), 0.0, 0.0};
       }});
  CHECK(driven_by_loads(nearly));

  StaticProblem sprung = problem;
  sprung.springs = {{"bed", {{{0, {0.25, 0.25, 0.25}}, 1.0}}, {}}};
  CHECK_FALSE(driven_by_loads(sprung));
}
