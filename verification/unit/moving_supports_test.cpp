#include <cmath>
#include <stdexcept>

#include "core/space/supports.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/tissue_samples.hpp"

using namespace finegauge;

TEST_CASE("merged supports are linear in time: each time has the displacement that a static search finds",
          "[supports]") {
  std::mt19937 generator(5);
  const RefinementForest forest = random_body({}, generator);
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  const auto first = [](double t) { return 1.0 + t; };
  const auto second = [](double t) { return std::sin(3.0 * t); };
  const auto a = [](const Eigen::Vector3d& X) { return Eigen::Vector3d(X.x() + 1.0, X.y(), 2.0); };
  const auto b = [](const Eigen::Vector3d& X) { return Eigen::Vector3d(X.z(), 1.0, X.x()); };
  const Eigen::Vector3d n(1.0, 0.3, -0.2), m(-0.4, 1.0, 0.6);
  const auto conditions = [&](double t, bool moving) {
    std::vector<SupportCondition> all = {{"x_min", n, a, first},
                                         {"y_min", m, b},
                                         {"z_min", std::nullopt, b, second},
                                         {"x_min", Eigen::Vector3d(0, 0, 1), a, second}};
    for (SupportCondition& condition : all) {
      if (moving || !condition.course) continue;
      const double factor = condition.course(t);
      const auto field = condition.displacement;
      condition.displacement = [factor, field](const Eigen::Vector3d& X) -> Eigen::Vector3d {
        return factor * field(X);
      };
      condition.course = {};
    }
    return all;
  };
  const Supports supports = find_supports(forest.base(), mesh, hanging, conditions(0.0, true));
  REQUIRE(supports.motions.size() == 3);
  std::vector<Eigen::Vector3d> displacement;
  double largest_motion = 0.0;
  for (const double t : {0.0, 0.3, -1.0, 7.5}) {
    const Supports expected = find_supports(forest.base(), mesh, hanging, conditions(t, false));
    prescribe(supports, t, displacement);
    REQUIRE(expected.motions.empty());
    REQUIRE(expected.reduced == supports.reduced);
    REQUIRE(displacement.size() == expected.displacement.size());
    for (std::size_t i = 0; i < displacement.size(); ++i) {
      CHECK(supports.held[i] == expected.held[i]);
      CHECK((displacement[i] - expected.displacement[i]).norm() <= 1e-13);
      if (t == 0.0) CHECK(displacement[i] == supports.displacement[i]);
      largest_motion = std::max(largest_motion, (displacement[i] - supports.displacement[i]).norm());
    }
  }
  CHECK(largest_motion > 1.0);
}

TEST_CASE("a course that is not finite is refused", "[supports]") {
  BoxMeshOptions box;
  const RefinementForest forest(box_mesh(box));
  const auto one = [](const Eigen::Vector3d&) { return Eigen::Vector3d(1.0, 0.0, 0.0); };
  const auto pole = [](double t) { return 1.0 / t; };
  CHECK_THROWS_AS(discretize(forest, {}, {{"x_min", std::nullopt, one, pole}}), std::invalid_argument);
  const auto later = [](double t) { return 1.0 / (1.0 - t); };
  const Discretization d = discretize(forest, {}, {{"x_min", std::nullopt, one, later}});
  std::vector<Eigen::Vector3d> displacement;
  prescribe(d.supports, 0.5, displacement);
  CHECK(displacement[0].x() == 2.0);
  CHECK_THROWS_AS(prescribe(d.supports, 1.0, displacement), std::invalid_argument);
}
