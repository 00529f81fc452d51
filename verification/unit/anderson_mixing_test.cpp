#include "core/solve/anderson_mixing.hpp"

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

/// Iterations until |g| falls below 1e-10 of the first, at most 200.
template <class Step>
int iterations(int depth, const Step& g_of, Eigen::VectorXd x) {
  AndersonMixing mixing(depth);
  const double first = g_of(x).norm();
  for (int k = 0; k < 200; ++k) {
    const Eigen::VectorXd g = g_of(x);
    if (g.norm() <= 1e-10 * first) return k;
    x = mixing.next(x, g);
  }
  return 200;
}

}  // namespace

TEST_CASE("a linear fixed point in n dimensions is found in n + 1 steps, even where plain steps diverge",
          "[anderson]") {
  std::mt19937 generator(1);
  constexpr int n = 5;
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) M(i, i) = -2.0 + 0.5 * i;  // eigenvalues of the iteration, some beyond one in size
  Eigen::VectorXd b(n);
  for (double& value : b) value = random_number(generator);
  const auto g = [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(M * x + b - x); };
  CHECK(iterations(0, g, Eigen::VectorXd::Zero(n)) == 200);
  CHECK(iterations(n, g, Eigen::VectorXd::Zero(n)) <= n + 2);
  CHECK(iterations(n, g, Eigen::VectorXd::Zero(n)) >= n);
}

TEST_CASE("mixing makes a slow nonlinear iteration fast", "[anderson]") {
  const auto g = [](const Eigen::VectorXd& x) {
    Eigen::VectorXd next(2);
    next << std::cos(x[1]), 0.95 * std::sin(x[0] + 0.3) + 0.1;
    return Eigen::VectorXd(next - x);
  };
  const int plain = iterations(0, g, Eigen::VectorXd::Zero(2)), mixed = iterations(3, g, Eigen::VectorXd::Zero(2));
  CAPTURE(plain, mixed);
  CHECK(plain < 200);
  CHECK(2 * mixed <= plain);
}

TEST_CASE("repeated iterates do no harm", "[anderson]") {
  AndersonMixing mixing(3);
  const Eigen::VectorXd x = Eigen::VectorXd::Ones(4), g = Eigen::VectorXd::Constant(4, 0.5);
  for (int k = 0; k < 5; ++k) CHECK(mixing.next(x, g) == x + g);
}
