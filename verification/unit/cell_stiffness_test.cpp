#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "core/elasticity/cell_geometry.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/strain_matrix.hpp"

using namespace finegauge;

namespace {

/// Σ w Bᵀ D B by the textbook, from the shape functions; for the mean dilatation with B-bar (Hughes 1980).
CellMatrix textbook_stiffness(CellShape shape, const CellVectors& corners, const Material& material) {
  std::vector<StrainMatrix> B;
  std::vector<double> weights;
  StrainMatrix mean = StrainMatrix::Zero();
  double volume = 0.0;
  for (int q = 0; q < quadrature_count(shape); ++q) {
    const Gradients dN = shape_gradients(shape, quadrature_point(shape, q));
    const Eigen::Matrix3d J = corners * dN.transpose();
    B.push_back(strain_matrix(J.inverse().transpose() * dN));
    weights.push_back(std::abs(J.determinant()) / (shape == CellShape::hexahedron ? 8.0 : 6.0));
    mean += weights[q] * B[q];
    volume += weights[q];
  }
  mean /= volume;
  CellMatrix K = CellMatrix::Zero();
  for (int q = 0; q < quadrature_count(shape); ++q) {
    if (material.dilatation == Dilatation::mean) {
      const Eigen::Matrix<double, 1, 24> change = (mean - B[q]).topRows<3>().colwise().sum() / 3.0;
      B[q].topRows<3>().rowwise() += change;
    }
    K += weights[q] * B[q].transpose() * elasticity_matrix(material) * B[q];
  }
  return K;
}

Eigen::VectorXd spectrum(CellShape shape, const CellMatrix& K) {
  const int n = 3 * corner_count(shape);
  const Eigen::MatrixXd used = K.topLeftCorner(n, n);
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(used, Eigen::EigenvaluesOnly).eigenvalues();
}

CellVectors block_cell(double x, double y, double z) {
  CellVectors corners;
  for (int c = 0; c < 8; ++c) corners.col(c) = Eigen::Vector3d(x * (c & 1), y * ((c >> 1) & 1), z * (c >> 2));
  return corners;
}

double condition(const CellVectors& corners, const Material& material) {
  const CellGeometry geometry = cell_geometry(CellShape::hexahedron, corners);
  const Eigen::VectorXd values =
      spectrum(CellShape::hexahedron, cell_stiffness(CellShape::hexahedron, geometry, material));
  return values[23] / values[6];
}

}  // namespace

TEST_CASE("the stiffness is that of the textbook", "[stiffness]") {
  std::mt19937 generator(21);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Dilatation dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  const double nu = GENERATE(-0.5, 0.0, 0.3, 0.4999);
  const Material material{.youngs_modulus = 2.5e3, .poisson_ratio = nu, .dilatation = dilatation};
  CAPTURE(int(shape), int(dilatation), nu);
  for (int trial = 0; trial < 10; ++trial) {
    const CellVectors corners = sample_cell(shape, 0.15, generator);
    const CellMatrix K = cell_stiffness(shape, cell_geometry(shape, corners), material);
    const CellMatrix expected = textbook_stiffness(shape, corners, material);
    CHECK_THAT((K - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff(), WithinAbs(0.0, 2e-14));
    CHECK((K - K.transpose()).cwiseAbs().maxCoeff() == 0.0);  // to the last bit
  }
}

TEST_CASE("a distorted cell has exactly six zero modes", "[stiffness]") {
  std::mt19937 generator(22);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Dilatation dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  const double nu = GENERATE(0.0, 0.3, 0.49);
  const Material material{.youngs_modulus = 1.0, .poisson_ratio = nu, .dilatation = dilatation};
  CAPTURE(int(shape), int(dilatation), nu);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::VectorXd values =
        spectrum(shape, cell_stiffness(shape, cell_geometry(shape, sample_cell(shape, 0.15, generator)), material));
    const double largest = values[values.size() - 1];
    CHECK_THAT(values.head(6).cwiseAbs().maxCoeff() / largest, WithinAbs(0.0, 1e-14));
    CHECK(values[6] / largest > 1e-4);  // spread of the elastic modes, some 50 to 1000 at these nu and distortions
  }
}

TEST_CASE("the spectrum of the unit cube spreads as 1 / (1 - 2 nu)", "[stiffness]") {
  // Printed to three or two digits, hence the tolerances.
  const auto [nu, expected, tolerance] = GENERATE(table<double, double, double>({{0.3, 19.5, 0.05 / 19.5},
                                                                                 {0.4, 42.0, 0.05 / 42.0},
                                                                                 {0.49, 447.0, 0.5 / 447.0},
                                                                                 {0.4999, 4.5e4, 0.05 / 4.5},
                                                                                 {0.499999, 4.5e6, 0.05 / 4.5}}));
  CAPTURE(nu);
  CHECK_THAT(condition(block_cell(1.0, 1.0, 1.0), {.youngs_modulus = 1.0, .poisson_ratio = nu}),
             WithinRel(expected, tolerance));
}

TEST_CASE("the spectrum of a flat plate spreads with the fourth power of its aspect ratio", "[stiffness]") {
  const auto [ratio, expected] = GENERATE(table<double, double>({{1.0, 4.2e1}, {10.0, 4.7e4}, {100.0, 4.5e8}}));
  CAPTURE(ratio);
  CHECK_THAT(condition(block_cell(ratio, ratio, 1.0), {.youngs_modulus = 1.0, .poisson_ratio = 0.4}),
             WithinRel(expected, 0.05 / 4.2));
}

TEST_CASE("the mean dilatation stays soft in shape as nu tends to one half", "[stiffness]") {
  // One mode alone changes the mean volume of a cell; all others must stay of the order of mu.
  std::mt19937 generator(23);
  const CellVectors corners = sample_cell(CellShape::hexahedron, 0.1, generator);
  const CellGeometry geometry = cell_geometry(CellShape::hexahedron, corners);
  const auto stiff_modes = [&](Dilatation dilatation) {
    const Material material{.youngs_modulus = 1.0, .poisson_ratio = 0.49999, .dilatation = dilatation};
    const Eigen::VectorXd values =
        spectrum(CellShape::hexahedron, cell_stiffness(CellShape::hexahedron, geometry, material));
    return (values.array() > 100.0 * material.mu()).count();
  };
  CHECK(stiff_modes(Dilatation::mean) == 1);
  CHECK(stiff_modes(Dilatation::standard) > 1);
}

TEST_CASE("the force is the derivative of the energy", "[stiffness]") {
  std::mt19937 generator(24);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Material material{.youngs_modulus = 1.0, .poisson_ratio = 0.3};
  const CellVectors corners = sample_cell(shape, 0.15, generator);
  const CellGeometry geometry = cell_geometry(shape, corners);
  const CellMatrix K = cell_stiffness(shape, geometry, material);
  const auto energy = [&](const Eigen::Matrix<double, 24, 1>& u) {
    double sum = 0.0;
    for (int q = 0; q < quadrature_count(shape); ++q) {
      const Eigen::Matrix3d H = Eigen::Map<const CellVectors>(u.data()) * geometry.gradients[q].transpose();
      const Eigen::Matrix3d strain = 0.5 * (H + H.transpose());
      sum += geometry.weights[q] *
             (material.mu() * strain.squaredNorm() + 0.5 * material.lambda() * strain.trace() * strain.trace());
    }
    return sum;
  };
  const CellVectors start = random_corner_vectors(shape, 0.1, generator);
  const Eigen::Matrix<double, 24, 1> u = Eigen::Map<const Eigen::Matrix<double, 24, 1>>(start.data());
  const Eigen::Matrix<double, 24, 1> force = K * u;
  for (int i = 0; i < 3 * corner_count(shape); ++i) {
    // The energy is quadratic, so that central differences are exact whatever the step.
    Eigen::Matrix<double, 24, 1> step = Eigen::Matrix<double, 24, 1>::Zero();
    step[i] = 0.5;
    CHECK_THAT(energy(u + step) - energy(u - step), WithinAbs(force[i], 1e-13));
  }
}

TEST_CASE("volumes are exact", "[geometry]") {
  // A frustum: squares of side 2 and 1 at height 3.
  CellVectors frustum = block_cell(2.0, 2.0, 3.0);
  for (int c = 4; c < 8; ++c)
    frustum.col(c).head<2>() = Eigen::Vector2d::Constant(0.5) + 0.5 * frustum.col(c).head<2>();
  CHECK_THAT(cell_geometry(CellShape::hexahedron, frustum).volume, WithinRel(3.0 / 3.0 * (4.0 + 1.0 + 2.0), 1e-14));

  std::mt19937 generator(25);
  for (int trial = 0; trial < 20; ++trial) {
    CellVectors corners = sample_cell(CellShape::tetrahedron, 0.15, generator);
    Eigen::Matrix4d homogeneous = Eigen::Matrix4d::Ones();
    homogeneous.topRows<3>() = corners.leftCols<4>();
    const double volume = std::abs(homogeneous.determinant()) / 6.0;
    CHECK_THAT(cell_geometry(CellShape::tetrahedron, corners).volume, WithinRel(volume, 1e-13));
    corners.col(0).swap(corners.col(1));  // the other orientation
    CHECK_THAT(cell_geometry(CellShape::tetrahedron, corners).volume, WithinRel(volume, 1e-13));
  }
}

TEST_CASE("children fill a cell exactly, even where a corner of it is folded", "[geometry]") {
  CellVectors corners = block_cell(1.0, 1.0, 1.0);
  corners.col(7).setConstant(0.1);
  double sum = 0.0, smallest = 1.0;
  for (int child = 0; child < 64; ++child) {
    CellVectors X;
    for (int c = 0; c < 8; ++c) {
      const Eigen::Vector3d xi =
          0.25 * Eigen::Vector3d((child & 3) + (c & 1), ((child >> 2) & 3) + ((c >> 1) & 1), (child >> 4) + (c >> 2));
      const auto N = shape_functions(CellShape::hexahedron, xi);
      X.col(c) = corners * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(N.data());
    }
    const double volume = cell_geometry(CellShape::hexahedron, X).volume;
    sum += volume;
    smallest = std::min(smallest, volume);
  }
  CHECK(smallest < 0.0);  // folded indeed
  CHECK_THAT(sum, WithinRel(cell_geometry(CellShape::hexahedron, corners).volume, 1e-13));
}

TEST_CASE("gradients differentiate linear fields exactly", "[geometry]") {
  std::mt19937 generator(26);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const double far_away = GENERATE(0.0, 1e3);
  CAPTURE(int(shape), far_away);
  // Corners are rounded at the size of their coordinates, and a gradient is a difference over a cell of size one.
  const double tolerance = 1e-14 * (1.0 + far_away);
  for (int trial = 0; trial < 10; ++trial) {
    const CellVectors corners = affine_image(shape, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Constant(far_away),
                                             sample_cell(shape, 0.15, generator));
    const CellGeometry geometry = cell_geometry(shape, corners);
    const auto error = [&](const Gradients& g) {
      return (corners * g.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    };
    for (int q = 0; q < quadrature_count(shape); ++q)
      CHECK_THAT(error(geometry.gradients[q]), WithinAbs(0.0, tolerance));
    CHECK_THAT(error(geometry.centre_gradients), WithinAbs(0.0, tolerance));
    CHECK_THAT(error(geometry.mean_gradients), WithinAbs(0.0, tolerance));
  }
}
