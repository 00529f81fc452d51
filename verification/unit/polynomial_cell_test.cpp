#include "core/elasticity/polynomial_cell.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

TEST_CASE("n Gauss points integrate polynomials up to degree 2 n - 1 and not the next even one", "[polynomial_cell]") {
  const int n = GENERATE(range(1, 9));
  CAPTURE(n);
  const GaussRule rule = gauss_rule(n);
  for (int power = 0; power <= 2 * n; ++power) {
    double sum = 0.0;
    for (int i = 0; i < n; ++i) sum += rule.weights[i] * std::pow(rule.points[i], power);
    CAPTURE(power);
    if (power < 2 * n)
      CHECK_THAT(sum, WithinAbs(1.0 / (power + 1), 1e-15));
    else
      CHECK(std::abs(sum - 1.0 / (power + 1)) > 1e-11);  // the n-point error of x^2n: 3e-10 at n = 8
  }
  CHECK_THROWS_AS(gauss_rule(0), std::invalid_argument);
  CHECK_THROWS_AS(gauss_rule(9), std::invalid_argument);
}

TEST_CASE("the polynomial cell of degree one is the trilinear cell", "[polynomial_cell]") {
  std::mt19937 generator(3);
  Material material;
  const CellVectors X = sample_cell(CellShape::hexahedron, 0.0, generator);  // where 2 and 3 points agree
  const Eigen::MatrixXd K = PolynomialCell(1).stiffness(X, material);
  const CellMatrix trilinear = cell_stiffness(CellShape::hexahedron, cell_geometry(CellShape::hexahedron, X), material);
  CHECK((K - trilinear).norm() < 1e-13 * trilinear.norm());
}

TEST_CASE("a polynomial cell has six rigid motions and the energy of any polynomial that it can follow",
          "[polynomial_cell]") {
  const int degree = GENERATE(1, 2, 3, 4);
  CAPTURE(degree);
  std::mt19937 generator(7);
  Material material;
  const PolynomialCell cell(degree);
  const CellVectors X = sample_cell(CellShape::hexahedron, 0.1, generator);
  const Eigen::MatrixXd K = cell.stiffness(X, material);
  const Eigen::VectorXd spectrum =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K, Eigen::EigenvaluesOnly).eigenvalues();
  CHECK(spectrum[5] < 1e-11 * spectrum[spectrum.size() - 1]);
  CHECK(spectrum[6] > 1e-6 * spectrum[spectrum.size() - 1]);

  // On a box of edges a, b, c: u_x = x^degree has ∫ (lambda + 2 mu) (degree x^(degree - 1))² dV.
  CellVectors box = sample_cell(CellShape::hexahedron, 0.0, generator);
  const Eigen::Vector3d edges(0.7, 1.3, 2.0);
  box = edges.asDiagonal() * box;
  const Eigen::MatrixXd K_box = cell.stiffness(box, material);
  const Eigen::Matrix3Xd places = cell.interpolate(box);
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, places.cols());
  u.row(0) = places.row(0).array().pow(degree);
  const Eigen::Map<const Eigen::VectorXd> v(u.data(), u.size());
  const double exact = (material.lambda() + 2.0 * material.mu()) * degree * degree / (2.0 * degree - 1.0) *
                       std::pow(edges.x(), 2 * degree - 1) * edges.y() * edges.z();
  CHECK_THAT(v.dot(K_box * v), WithinRel(exact, 1e-12));
}

TEST_CASE("with the mean dilatation a polynomial cell of degree one is the trilinear cell, and none of them locks",
          "[polynomial_cell]") {
  std::mt19937 generator(5);
  Material material;
  material.dilatation = Dilatation::mean;
  material.poisson_ratio = 0.4999;
  const CellVectors X = sample_cell(CellShape::hexahedron, 0.0, generator);
  const Eigen::MatrixXd K = PolynomialCell(1).stiffness(X, material);
  const CellMatrix trilinear = cell_stiffness(CellShape::hexahedron, cell_geometry(CellShape::hexahedron, X), material);
  CHECK((K - trilinear).norm() < 1e-13 * trilinear.norm());

  // Of 3 (p + 1)^3 displacements as many change the volume as there are polynomials of total degree p - 1: the others
  // keep an energy of the order of mu.
  const int degree = GENERATE(2, 3);
  const int changing = degree * (degree + 1) * (degree + 2) / 6;
  const CellVectors distorted = sample_cell(CellShape::hexahedron, 0.1, generator);
  const auto stiff_count = [&](Dilatation dilatation) {
    material.dilatation = dilatation;
    const Eigen::VectorXd spectrum = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(
                                         PolynomialCell(degree).stiffness(distorted, material), Eigen::EigenvaluesOnly)
                                         .eigenvalues();
    return (spectrum.array() > 20.0 * material.mu()).count();
  };
  CHECK(stiff_count(Dilatation::mean) == changing);
  CHECK(stiff_count(Dilatation::standard) > 2 * changing);
}

TEST_CASE("shape functions of a polynomial cell are one at their node and sum to one", "[polynomial_cell]") {
  const int degree = GENERATE(1, 2, 3, 4);
  const PolynomialCell cell(degree);
  for (int i = 0; i < cell.node_count(); ++i) {
    Eigen::VectorXd N = cell.shape_functions(cell.node(i));
    N[i] -= 1.0;
    CHECK(N.cwiseAbs().maxCoeff() < 1e-14);
  }
  CHECK_THAT(cell.shape_functions({0.21, 0.77, 0.4}).sum(), WithinAbs(1.0, 1e-14));
}
