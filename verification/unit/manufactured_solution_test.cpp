#include "verification/support/manufactured_solution.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

using std::numbers::pi;

double difference(const Jet& a, double value, const Eigen::Vector3d& gradient, const Eigen::Matrix3d& hessian) {
  return std::max({std::abs(a.value - value), (a.gradient - gradient).cwiseAbs().maxCoeff(),
                   (a.hessian - hessian).cwiseAbs().maxCoeff()});
}

}  // namespace

TEST_CASE("jets have the closed derivatives of x² y - exp(y z) + 3 and of sin(x y) cos z", "[jet]") {
  std::mt19937 generator(1);
  for (int sample = 0; sample < 20; ++sample) {
    const Eigen::Vector3d X = random_vector(generator);
    CAPTURE(X.transpose());
    const double x = X[0], y = X[1], z = X[2];
    const Jets at = coordinates_at(X);

    const double e = std::exp(y * z);
    Eigen::Matrix3d hessian;
    hessian << 2 * y, 2 * x, 0,               //
        2 * x, -z * z * e, -(1 + y * z) * e,  //
        0, -(1 + y * z) * e, -y * y * e;
    const Jet polynomial = at[0] * at[0] * at[1] - exp(at[1] * at[2]) + 3.0;
    CHECK(difference(polynomial, x * x * y - e + 3, {2 * x * y, x * x - z * e, -y * e}, hessian) < 1e-14);

    const double s = std::sin(x * y), c = std::cos(x * y), sz = std::sin(z), cz = std::cos(z);
    hessian << -y * y * s * cz, (c - x * y * s) * cz, -y * c * sz,  //
        (c - x * y * s) * cz, -x * x * s * cz, -x * c * sz,         //
        -y * c * sz, -x * c * sz, -s * cz;
    CHECK(difference(sin(at[0] * at[1]) * cos(at[2]), s * cz, {y * c * cz, x * c * cz, -s * sz}, hessian) < 1e-14);
  }
}

TEST_CASE("the isochoric solution keeps its volume and is balanced by 3 mu pi² u", "[manufactured]") {
  Material material;
  material.poisson_ratio = GENERATE(0.0, 0.4, 0.4999);
  const ManufacturedSolution solution = isochoric_solution();
  std::mt19937 generator(2);
  for (int sample = 0; sample < 20; ++sample) {
    const Eigen::Vector3d X = random_vector(generator);
    const Jets u = solution.formula(coordinates_at(X));
    CHECK(std::abs(u[0].gradient[0] + u[1].gradient[1] + u[2].gradient[2]) < 1e-14);
    const Eigen::Vector3d expected = 3.0 * material.mu() * pi * pi * displacement(solution, X);
    // Round-off of a vanishing grad div u, times lambda / mu.
    const double tolerance = 1e-14 * (material.lambda() + material.mu());
    CHECK((body_force(solution, material, X) - expected).cwiseAbs().maxCoeff() < tolerance * 10.0);
    CHECK(expected.norm() > 1.0);
  }
}

TEST_CASE("the body force balances the stress: f + div σ = 0 by differences", "[manufactured]") {
  Material material;
  material.poisson_ratio = GENERATE(0.3, 0.4999);
  const ManufacturedSolution solution = GENERATE(smooth_solution(), isochoric_solution());
  CAPTURE(solution.name, material.poisson_ratio);
  std::mt19937 generator(3);
  const double h = 1e-4;
  for (int sample = 0; sample < 10; ++sample) {
    const Eigen::Vector3d X = random_vector(generator);
    Eigen::Vector3d divergence = Eigen::Vector3d::Zero();
    // σ_ij by Voigt position: xx yy zz xy yz zx.
    const int voigt[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
    for (int j = 0; j < 3; ++j) {
      const Voigt change = stress(solution, material, X + h * Eigen::Vector3d::Unit(j)) -
                           stress(solution, material, X - h * Eigen::Vector3d::Unit(j));
      for (int i = 0; i < 3; ++i) divergence[i] += change[voigt[i][j]] / (2.0 * h);
    }
    // Truncation h²/6 times third derivatives of the strain, about π⁴ at most, and round-off of the stress over h.
    const double tolerance = 1e-6 * (material.lambda() + material.mu());
    CHECK((body_force(solution, material, X) + divergence).cwiseAbs().maxCoeff() < tolerance);
  }
}

TEST_CASE("the smooth solution is the published one", "[manufactured]") {
  const Eigen::Vector3d X(0.3, 0.7, 0.9);
  const Eigen::Vector3d expected =
      0.1 * Eigen::Vector3d(std::sin(pi * 0.3) * std::cos(pi * 0.7) * std::exp(0.45),
                            std::cos(pi * 0.3) * std::sin(pi * 0.9) + 0.3 * 0.7 * 0.9, std::sin(pi * 1.0) * 0.81);
  CHECK((displacement(smooth_solution(), X) - expected).norm() < 1e-15);
}
