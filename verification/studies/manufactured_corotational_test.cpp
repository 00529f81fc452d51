#include "verification/studies/manufactured_corotational.hpp"

#include <Eigen/LU>

#include "verification/support/check_claims.hpp"

using namespace finegauge;

TEST_CASE("corotational statics give back any displacement from its forces and tend to the corotated energy",
          "[manufactured][corotational]") {
  const Evidence evidence = manufactured_corotational_evidence({});
  check_claims(evidence, 50);
  // Nodes hang in every body that is recovered, and in one of those under the forces of an energy.
  REQUIRE(evidence.tables.size() > 2);
  const auto hanging = [&](std::size_t table) {
    int rows = 0;
    for (const auto& row : evidence.tables[table].rows) rows += std::get<double>(row[table == 0 ? 2 : 3]) > 0.0;
    return rows;
  };
  REQUIRE(evidence.tables[0].columns[2] == "hanging");
  REQUIRE(evidence.tables[2].columns[3] == "hanging");
  CHECK(hanging(0) == static_cast<int>(evidence.tables[0].rows.size()));
  CHECK(hanging(2) == 3);
}

TEST_CASE("a turn alone has no force in either energy, and no rotation hides in the motions", "[manufactured]") {
  const Material material;
  const Motion turn = turned_motion(2.5, 0.0, smooth_solution());
  for (const HyperelasticLaw law : {HyperelasticLaw::corotated, HyperelasticLaw::saint_venant_kirchhoff}) {
    const Eigen::Vector3d X(0.2, 0.7, 0.4);
    CHECK(hyperelastic_body_force(turn, law, material, X).norm() < 1e-11 * material.youngs_modulus);
    CHECK(piola_stress(law, material, turn.gradient(X)).norm() < 1e-14 * material.youngs_modulus);
  }
  // The bar's ends face each other's opposite direction, and its cells are not inverted.
  const Motion bar = bar_motion(3.14159, 1.0, 0.125, 0.0);
  const Eigen::Matrix3d first = bar.gradient({0.0, 0.0, 0.0}), last = bar.gradient({1.0, 0.0, 0.0});
  CHECK(first.col(0).dot(last.col(0)) < -0.99);
  CHECK(first.determinant() > 0.5);
  CHECK(last.determinant() > 0.5);
}
