#include "core/solve/conjugate_gradients.hpp"

#include <cmath>
#include <limits>

#include "core/solve/direct_solver.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

/// A chain of springs, stiffness one in every direction, the last node tied to the ground by `ground`.
struct Chain {
  BlockPattern pattern;
  BlockMatrix<double> A;

  Chain(int nodes, double ground) {
    pattern.row_start.push_back(0);
    for (int i = 0; i < nodes; ++i) {
      for (int j = std::max(0, i - 1); j <= std::min(nodes - 1, i + 1); ++j) {
        if (j == i) pattern.diagonal.push_back(pattern.block_count());
        pattern.column.push_back(j);
      }
      pattern.row_start.push_back(pattern.block_count());
    }
    A.reset(pattern);
    for (int i = 0; i < nodes; ++i)
      for (int p = pattern.row_start[i]; p < pattern.row_start[i + 1]; ++p) {
        const int neighbours = (i > 0) + (i + 1 < nodes);
        const double diagonal = neighbours + (i + 1 == nodes ? ground : 0.0);
        A.block(p) = (pattern.column[p] == i ? diagonal : -1.0) * Eigen::Matrix3d::Identity();
      }
  }
  Chain(const Chain&) = delete;
  Chain& operator=(const Chain&) = delete;
};

const Preconditioner identity = [](const Eigen::VectorXd& r, Eigen::VectorXd& z) { z = r; };

Eigen::VectorXd random_vector_of(int size, unsigned seed) {
  std::mt19937 generator(seed);
  Eigen::VectorXd b(size);
  for (double& value : b) value = random_number(generator);
  return b;
}

}  // namespace

TEST_CASE("conjugate gradients end at the tolerance asked for, and say so truly", "[cg]") {
  const double tolerance = GENERATE(1e-3, 1e-6, 1e-10);
  const Chain chain(40, 1.0);
  const Eigen::VectorXd b = random_vector_of(120, 1);
  Eigen::VectorXd x = random_vector_of(120, 2), Ax;
  const SolveReport report = conjugate_gradients(chain.A, b, identity, {tolerance, 1000}, x);
  multiply(chain.A, x, Ax);
  CHECK(report.converged);
  CHECK(report.relative_residual <= tolerance);
  CHECK(report.relative_residual == (b - Ax).norm() / b.norm());
  CHECK(report.iterations <= 60);  // 40 different eigenvalues: 40 steps without round-off
  CHECK(report.iterations >= 20);
}

TEST_CASE("conjugate gradients stop as soon as the residual asked for is reached, and not before", "[cg]") {
  // Every node tied to the ground: eigenvalues in [1, 5], so that the residual falls by about (√5 - 1) / (√5 + 1) =
  // 0.38 an iteration (Greenbaum 1997) and not all at once in the last one, as that of a chain tied at its end does.
  Chain chain(40, 1.0);
  for (const int p : chain.pattern.diagonal) chain.A.block(p) += Eigen::Matrix3d::Identity();
  const double tolerance = GENERATE(1e-2, 1e-4, 1e-7, 1e-10);
  CAPTURE(tolerance);
  const Eigen::VectorXd b = random_vector_of(120, 1);
  Eigen::VectorXd x = random_vector_of(120, 2), Ax;
  CHECK(conjugate_gradients(chain.A, b, identity, {tolerance, 1000}, x).converged);
  multiply(chain.A, x, Ax);
  CHECK((b - Ax).norm() <= tolerance * b.norm());
  CHECK((b - Ax).norm() >= 0.1 * tolerance * b.norm());
}

TEST_CASE("the limit of iterations is reported as not converged", "[cg]") {
  const Chain chain(40, 1.0);
  const Eigen::VectorXd b = random_vector_of(120, 1);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(120);
  const SolveReport report = conjugate_gradients(chain.A, b, identity, {1e-10, 5}, x);
  CHECK_FALSE(report.converged);
  CHECK(report.iterations == 5);
  CHECK(report.relative_residual > 1e-10);
  CHECK(x.allFinite());
}

TEST_CASE("a start that solves the system costs no iteration", "[cg]") {
  const Chain chain(10, 1.0);
  Eigen::VectorXd x = random_vector_of(30, 1), b;
  const Eigen::VectorXd start = x;
  multiply(chain.A, x, b);
  const SolveReport report = conjugate_gradients(chain.A, b, identity, {1e-12, 100}, x);
  CHECK(report.converged);
  CHECK(report.iterations == 0);
  CHECK(x == start);
}

TEST_CASE("without a load the solution is zero, whatever the start", "[cg]") {
  const Chain chain(10, 1.0);
  Eigen::VectorXd x = random_vector_of(30, 1);
  const SolveReport report = conjugate_gradients(chain.A, Eigen::VectorXd::Zero(30), identity, {1e-12, 100}, x);
  CHECK(report.converged);
  CHECK(report.relative_residual == 0.0);
  CHECK(x.isZero(0.0));
}

TEST_CASE("an indefinite matrix, an indefinite preconditioner and NaN are breakdowns, not solutions", "[cg]") {
  const Eigen::VectorXd b = random_vector_of(120, 1);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(120);
  SECTION("matrix") {
    Chain chain(40, 1.0);
    for (double& value : chain.A.values) value = -value;
    CHECK_FALSE(conjugate_gradients(chain.A, b, identity, {1e-10, 1000}, x).converged);
  }
  SECTION("matrix with one negative direction") {
    Chain chain(40, 1.0);
    chain.A.block(chain.pattern.diagonal[0]) *= -3.0;
    const SolveReport report = conjugate_gradients(chain.A, b, identity, {1e-10, 1000}, x);
    CHECK_FALSE(report.converged);
    CHECK(report.iterations < 1000);
  }
  SECTION("preconditioner") {
    const Chain chain(40, 1.0);
    const auto negative = [](const Eigen::VectorXd& r, Eigen::VectorXd& z) { z = -r; };
    const SolveReport report = conjugate_gradients(chain.A, b, negative, {1e-10, 1000}, x);
    CHECK_FALSE(report.converged);
    CHECK(report.iterations == 0);
  }
  SECTION("NaN") {
    const Chain chain(40, 1.0);
    Eigen::VectorXd wrong = b;
    wrong[7] = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(conjugate_gradients(chain.A, wrong, identity, {1e-10, 1000}, x).converged);
  }
}

TEST_CASE("units that are powers of two apart stop at the same iteration with the same bits", "[cg]") {
  const Chain chain(40, 1.0);
  const Eigen::VectorXd b = random_vector_of(120, 1);
  const auto solve = [&](const BlockMatrix<double>& A, const Eigen::VectorXd& right, int& iterations) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(120);
    const SolveReport report = conjugate_gradients(A, right, identity, {1e-7, 1000}, x);
    CHECK(report.converged);
    iterations = report.iterations;
    return x;
  };
  int iterations = 0;
  const Eigen::VectorXd x = solve(chain.A, b, iterations);
  for (const int of_A : {-31, -8, 0, 5, 33})
    for (const int of_b : {-101, -40, 1, 77}) {
      CAPTURE(of_A, of_b);
      Chain scaled(40, 1.0);
      for (double& value : scaled.A.values) value = std::ldexp(value, of_A);
      int found = 0;
      const Eigen::VectorXd y = solve(scaled.A, Eigen::VectorXd(std::ldexp(1.0, of_b) * b), found);
      CHECK(found == iterations);
      CHECK(Eigen::VectorXd(std::ldexp(1.0, of_A - of_b) * y) == x);
    }
}

TEST_CASE("the direct solver solves to round-off", "[direct]") {
  const Chain chain(40, 1.0);
  const Eigen::VectorXd b = random_vector_of(120, 1);
  const DirectSolver solver(chain.A);
  REQUIRE(solver.factored());
  Eigen::VectorXd Ax;
  multiply(chain.A, solver.solve(b), Ax);
  CHECK((Ax - b).norm() <= 1e-13 * b.norm());
  CHECK(solver.factor_nonzeros() >= 120.0);
}

TEST_CASE("the direct solver says when a matrix is singular or indefinite", "[direct]") {
  CHECK_FALSE(DirectSolver(Chain(40, 0.0).A).factored());
  CHECK_FALSE(DirectSolver(Chain(40, -1.0).A).factored());
}

TEST_CASE("a factor is kept while the matrix is the same to the last bit, and only then", "[direct]") {
  FactorCache cache;
  Chain chain(10, 1.0);
  const auto first = cache.factor(chain.A);
  CHECK(cache.factor(chain.A) == first);
  const Chain same(10, 1.0);
  CHECK(cache.factor(same.A) == first);
  chain.A.values[0] = std::nextafter(chain.A.values[0], 2.0 * chain.A.values[0]);
  const auto second = cache.factor(chain.A);
  CHECK(second != first);
  CHECK(cache.factor(Chain(11, 1.0).A) != second);
  // Factors are made of 2^-e A: twice a matrix looks the same there.
  Chain twice(10, 1.0);
  const auto once = cache.factor(twice.A);
  for (double& value : twice.A.values) value *= 2.0;
  const auto of_twice = cache.factor(twice.A);
  const Eigen::VectorXd b = random_vector_of(30, 3);
  CHECK(of_twice->solve(b) == 0.5 * once->solve(b));
}

TEST_CASE("a residual that drifted from the true one is not believed", "[cg]") {
  const Chain chain(40, 1.0);
  const Eigen::VectorXd b = random_vector_of(120, 1);
  int applications = 0;
  ConjugateGradientParts parts;
  // Wrong by a thousandth in the first iterations, as round-off is by far less: the recursion knows nothing of it.
  parts.apply = [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) {
    multiply(chain.A, x, y);
    if (const int k = applications++; k > 0 && k < 6) y *= 1.001;
  };
  parts.precondition = identity;
  ConjugateGradientRules rules;
  rules.squared_residual = 1e-20 * b.squaredNorm();
  ConjugateGradientVectors vectors;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(120), Ax;
  const SolveReport report = conjugate_gradients(parts, b, rules, vectors, x);
  multiply(chain.A, x, Ax);
  CHECK(report.converged);
  CHECK((b - Ax).squaredNorm() <= rules.squared_residual);
  CHECK(vectors.r == b - Ax);
  CHECK(report.iterations > 60);  // 40 eigenvalues, and again after the restart
}

TEST_CASE("an iteration that only round-off keeps from its end stops where it is told to", "[cg]") {
  const Chain chain(40, 1.0);
  const Eigen::VectorXd b = random_vector_of(120, 1);
  ConjugateGradientParts parts;
  parts.apply = [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) { multiply(chain.A, x, y); };
  parts.precondition = identity;
  ConjugateGradientRules rules;
  rules.squared_residual = 1e-40 * b.squaredNorm();  // the recursion gets there, b - A x cannot
  const auto solve = [&](double stagnation) {
    rules.stagnation = stagnation;
    ConjugateGradientVectors vectors;
    Eigen::VectorXd x = Eigen::VectorXd::Zero(120), Ax;
    const SolveReport report = conjugate_gradients(parts, b, rules, vectors, x);
    multiply(chain.A, x, Ax);
    CHECK(vectors.r == b - Ax);
    CHECK((b - Ax).norm() < 1e-13 * b.norm());
    CHECK_FALSE(report.converged);
    return report.iterations;
  };
  CHECK(solve(0.25) < 500);
  CHECK(solve(std::numeric_limits<double>::infinity()) == rules.iterations);
}

TEST_CASE("a preconditioner that is renewed on the way is used from there, and one that fails ends it", "[cg]") {
  const Chain chain(40, 1.0);
  const Eigen::VectorXd b = random_vector_of(120, 1);
  const DirectSolver factor(chain.A);
  bool renewed = false;
  int asked = 0;
  Renewal answer = Renewal::renewed;
  ConjugateGradientParts parts;
  parts.apply = [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) { multiply(chain.A, x, y); };
  parts.precondition = [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) { z = renewed ? factor.solve(r) : r; };
  parts.renew = [&](int iterations) {
    CHECK(iterations == asked++);
    if (iterations != 3) return Renewal::none;
    renewed = answer == Renewal::renewed;
    return answer;
  };
  ConjugateGradientRules rules;
  rules.squared_residual = 1e-20 * b.squaredNorm();
  ConjugateGradientVectors vectors;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(120), Ax;
  SolveReport report = conjugate_gradients(parts, b, rules, vectors, x);
  CHECK(report.converged);
  CHECK(report.iterations == 4);  // three with the old one, one with the inverse

  renewed = false;
  asked = 0;
  answer = Renewal::failed;
  x.setZero();
  report = conjugate_gradients(parts, b, rules, vectors, x);
  multiply(chain.A, x, Ax);
  CHECK_FALSE(report.converged);
  CHECK(report.iterations == 3);
  CHECK(vectors.r == b - Ax);
}

TEST_CASE("a small residual is no end while the last iteration changed x too much, and a start is asked for one",
          "[cg]") {
  const Chain chain(40, 1.0);
  const Eigen::VectorXd b = random_vector_of(120, 1);
  Eigen::VectorXd before = Eigen::VectorXd::Zero(120), x = before;
  double largest = 0.0;
  int asked = 0;
  const Settled settled = [&](const Eigen::VectorXd& change) {
    CHECK((x - before - change).norm() <= 1e-14 * x.norm());
    before = x;
    ++asked;
    largest = change.norm();
    return largest <= 1e-9;
  };
  // From the first iteration on the residual suffices.
  const SolveReport report = conjugate_gradients(chain.A, b, identity, {1e3, 1000}, x, settled);
  CHECK(report.converged);
  CHECK(asked == report.iterations);
  CHECK(largest <= 1e-9);
  CHECK(report.relative_residual < 1e-9);
  const int iterations = report.iterations;
  CHECK(iterations > 20);
  const SolveReport again = conjugate_gradients(chain.A, b, identity, {1e3, 1000}, x, settled);
  CHECK(again.converged);
  CHECK(again.iterations == 1);
  const SolveReport never =
      conjugate_gradients(chain.A, b, identity, {1e3, 30}, x, [](const Eigen::VectorXd&) { return false; });
  CHECK_FALSE(never.converged);
}
