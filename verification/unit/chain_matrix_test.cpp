#include "core/needle/chain_matrix.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <limits>
#include <random>

#include "verification/support/catch.hpp"
#include "verification/support/needle_samples.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

Eigen::MatrixXd random_dense(Eigen::Index rows, Eigen::Index columns, std::mt19937& generator) {
  Eigen::MatrixXd A(rows, columns);
  for (Eigen::Index j = 0; j < columns; ++j)
    for (Eigen::Index i = 0; i < rows; ++i) A(i, j) = random_number(generator);
  return A;
}

/// Symmetric, of any inertia.
ChainMatrix random_chain(int nodes, std::mt19937& generator) {
  ChainMatrix A;
  A.set_zero(nodes);
  for (Matrix6& D : A.diagonal) {
    const Matrix6 X = random_dense(6, 6, generator);
    D = X + X.transpose();
  }
  for (Matrix6& U : A.upper) U = random_dense(6, 6, generator);
  return A;
}

/// Σ over links of XᵀX.
ChainMatrix random_positive_chain(int nodes, std::mt19937& generator) {
  ChainMatrix A;
  A.set_zero(nodes);
  for (Matrix6& D : A.diagonal) D = 0.01 * Matrix6::Identity();
  for (int i = 0; i + 1 < nodes; ++i) {
    const Eigen::MatrixXd X = random_dense(12, 12, generator), S = X.transpose() * X;
    A.diagonal[i] += S.topLeftCorner<6, 6>();
    A.upper[i] += S.topRightCorner<6, 6>();
    A.diagonal[i + 1] += S.bottomRightCorner<6, 6>();
  }
  return A;
}

int negative_eigenvalues(const Eigen::MatrixXd& A) {
  return static_cast<int>((Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A).eigenvalues().array() < 0.0).count());
}

}  // namespace

TEST_CASE("a chain matrix multiplies as the dense one", "[needle][chain]") {
  std::mt19937 generator(21);
  for (const int nodes : {1, 2, 9}) {
    const ChainMatrix A = random_chain(nodes, generator);
    const Eigen::VectorXd x = random_dense(6 * nodes, 1, generator);
    Eigen::VectorXd y;
    multiply(A, x, y);
    CHECK((y - dense(A) * x).norm() < 1e-14 * y.norm());
  }
}

TEST_CASE("a positive definite chain is solved as by a dense factorization", "[needle][chain]") {
  std::mt19937 generator(22);
  for (const int nodes : {1, 2, 3, 30}) {
    CAPTURE(nodes);
    const ChainMatrix A = random_positive_chain(nodes, generator);
    const Eigen::MatrixXd D = dense(A), b = random_dense(6 * nodes, 3, generator);
    const ChainFactor factor(A);
    REQUIRE(factor.factored());
    CHECK(factor.negative_pivots() == 0);
    Eigen::MatrixXd x = b;
    factor.solve(x);
    // Backward stable: the residual is round-off of ‖A‖ ‖x‖, whatever the condition.
    CHECK((D * x - b).norm() < 1e-14 * D.norm() * x.norm());
    CHECK((x - D.ldlt().solve(b)).norm() < 1e-10 * x.norm());
  }
}

TEST_CASE("an indefinite chain is solved, and its negative eigenvalues are counted", "[needle][chain]") {
  std::mt19937 generator(23);
  int seen = 0;
  for (int trial = 0; trial < 200; ++trial) {
    CAPTURE(trial);
    const int nodes = 1 + trial % 6;
    const ChainMatrix A = random_chain(nodes, generator);
    const Eigen::MatrixXd D = dense(A), b = random_dense(6 * nodes, 1, generator);
    const ChainFactor factor(A);
    REQUIRE(factor.factored());
    CHECK(factor.negative_pivots() == negative_eigenvalues(D));
    seen += factor.negative_pivots();
    Eigen::MatrixXd x = b;
    factor.solve(x);
    // Without pivots across nodes a block may be poor by chance: a hundred times round-off is lost at the worst of 200.
    CHECK((D * x - b).norm() < 1e-11 * D.norm() * x.norm());
  }
  CHECK(seen > 1000);  // about half of 4,200
}

TEST_CASE("a block without any diagonal is regular and needs pivots of two rows", "[needle][chain]") {
  ChainMatrix A;
  A.set_zero(1);
  A.diagonal[0](0, 1) = A.diagonal[0](1, 0) = 2.0;
  A.diagonal[0](2, 2) = 3.0;
  A.diagonal[0](3, 5) = A.diagonal[0](5, 3) = -0.5;
  A.diagonal[0](4, 4) = -7.0;
  const ChainFactor factor(A);
  REQUIRE(factor.factored());
  CHECK(factor.negative_pivots() == 3);
  Eigen::MatrixXd x = Eigen::VectorXd::LinSpaced(6, 1.0, 6.0);
  factor.solve(x);
  Eigen::VectorXd expected(6);
  expected << 1.0, 0.5, 1.0, -12.0, -5.0 / 7.0, -8.0;
  CHECK((x - expected).norm() < 1e-15 * 20.0);
}

TEST_CASE("a singular or infinite pivot is reported, however the units are chosen", "[needle][chain]") {
  std::mt19937 generator(24);
  const double unit = GENERATE(1e-12, 1.0, 1e12);
  CAPTURE(unit);
  Eigen::Matrix<double, 6, 1> s;
  s << Eigen::Vector3d::Ones(), Eigen::Vector3d::Constant(unit);
  const auto rescaled = [&](ChainMatrix A) {
    for (Matrix6& D : A.diagonal) D = s.asDiagonal() * D * s.asDiagonal();
    for (Matrix6& U : A.upper) U = s.asDiagonal() * U * s.asDiagonal();
    return A;
  };
  // Rank 6 in a link of two nodes: the second pivot is zero.
  const Eigen::MatrixXd X = random_dense(6, 12, generator), S = X.transpose() * X;
  ChainMatrix A;
  A.set_zero(2);
  A.diagonal[0] = S.topLeftCorner<6, 6>();
  A.upper[0] = S.topRightCorner<6, 6>();
  A.diagonal[1] = S.bottomRightCorner<6, 6>();
  CHECK_FALSE(ChainFactor(rescaled(A)).factored());
  // One stiff enough spring more in each direction, and it is not.
  A.diagonal[1] += 1e-6 * Matrix6::Identity();
  CHECK(ChainFactor(rescaled(A)).factored());
  A.diagonal[1](4, 4) = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(ChainFactor(A).factored());
  A.diagonal[1](4, 4) = std::numeric_limits<double>::infinity();
  CHECK_FALSE(ChainFactor(A).factored());
}

TEST_CASE("held dofs are solved as zero, the others as without them", "[needle][chain]") {
  std::mt19937 generator(25);
  const int nodes = 5;
  ChainMatrix A = random_positive_chain(nodes, generator);
  const Eigen::MatrixXd D = dense(A);
  const HeldDofs held = {hold_all, 0, 2, hold_rotation, hold_position};
  std::vector<int> free;
  for (int dof = 0; dof < 6 * nodes; ++dof)
    if ((held[dof / 6] >> dof % 6 & 1u) == 0u) free.push_back(dof);
  REQUIRE(free.size() == 17);
  const Eigen::VectorXd b = random_dense(6 * nodes, 1, generator);

  hold(held, A);
  Eigen::VectorXd x = b;
  hold(held, x);
  CHECK((dense(A) - dense(A).transpose()).norm() == 0.0);
  CHECK(dense(A).diagonal() == D.diagonal());  // the node's own scale
  const ChainFactor factor(A);
  REQUIRE(factor.factored());
  factor.solve(x);
  const Eigen::VectorXd x_free = D(free, free).ldlt().solve(b(free));
  CHECK((x(free) - x_free).norm() < 1e-11 * x_free.norm());
  x(free).setZero();
  CHECK(x.norm() == 0.0);
}

TEST_CASE("held dofs without stiffness, or with a negative one, get a positive pivot", "[needle][chain]") {
  ChainMatrix A;
  A.set_zero(1);
  A.diagonal[0].diagonal() << 0.0, 5.0, -3.0, 0.0, 0.0, 0.0;
  hold({hold_all}, A);
  Eigen::Matrix<double, 6, 1> expected;
  expected << 5.0, 5.0, 3.0, 1.0, 1.0, 1.0;
  CHECK(A.diagonal[0] == Matrix6(expected.asDiagonal()));
  CHECK(ChainFactor(A).negative_pivots() == 0);
}
