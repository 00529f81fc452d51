#include "core/elasticity/cell_response.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/mesh/base_mesh.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

const Material corotational_tissue{
    .youngs_modulus = 1.0e3, .poisson_ratio = 0.3, .kinematics = Kinematics::corotational};

double largest_force(const CellVectors& force) { return force.colwise().norm().maxCoeff(); }

Voigt hooke(const Material& material, const Eigen::Matrix3d& H) {
  const Eigen::Matrix3d S =
      material.mu() * (H + H.transpose()) + material.lambda() * H.trace() * Eigen::Matrix3d::Identity();
  return (Voigt() << S(0, 0), S(1, 1), S(2, 2), S(0, 1), S(1, 2), S(2, 0)).finished();
}

/// MacNeal & Harder (1985): the unit cube in seven hexahedra, one inside and one on each of its faces.
BaseMesh patch_of_seven() {
  BaseMesh mesh;
  mesh.nodes.resize(3, 16);
  for (int c = 0; c < 8; ++c) mesh.nodes.col(c) = Eigen::Vector3d(c & 1, (c >> 1) & 1, c >> 2);
  const double inner[8][3] = {{.249, .342, .192}, {.826, .288, .288}, {.850, .649, .263}, {.273, .750, .230},
                              {.320, .186, .643}, {.677, .305, .683}, {.788, .693, .644}, {.165, .745, .702}};
  for (int k = 0; k < 8; ++k) mesh.nodes.col(8 + vtk_corner_order[k]) = Eigen::Vector3d(inner[k]);
  mesh.cells.push_back({8, 9, 10, 11, 12, 13, 14, 15});
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      std::array<int, 8> cell;
      for (int c = 0; c < 8; ++c) {
        const int on_face = (c & ~(1 << axis)) | (side << axis);
        const bool outside = ((c >> axis) & 1) == side;
        cell[c] = outside ? on_face : 8 + on_face;
      }
      mesh.cells.push_back(cell);
    }
  return mesh;
}

CellVectors corners_of(const BaseMesh& mesh, int cell, const Eigen::Matrix3Xd& nodal) {
  CellVectors values;
  for (int c = 0; c < 8; ++c) values.col(c) = nodal.col(mesh.cells[cell][c]);
  return values;
}

}  // namespace

TEST_CASE("a rigid motion has no force", "[corotational]") {
  std::mt19937 generator(41);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Dilatation dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  const double degrees = GENERATE(0.0, 10.0, 90.0, 179.9999, 180.0, 360.0);
  CAPTURE(int(shape), int(dilatation), degrees);
  Material material = corotational_tissue;
  material.dilatation = dilatation;
  for (int trial = 0; trial < 20; ++trial) {
    const CellVectors X = sample_cell(shape, 0.15, generator);
    const CellGeometry geometry = cell_geometry(shape, X);
    const CellMatrix K = cell_stiffness(shape, geometry, material);
    const Eigen::Matrix3d turn = turn_about_random_axis(degrees * std::numbers::pi / 180.0, generator);
    const CellVectors x = affine_image(shape, turn, 2.0 * random_vector(generator), X);
    const Eigen::Matrix3d R = cell_rotation(geometry, material, x);
    CHECK_THAT((R - turn).cwiseAbs().maxCoeff(), WithinAbs(0.0, 1e-13));
    // E h² = 1e3 N; round-off of positions of size 2 on a cell of size 1.
    CHECK_THAT(largest_force(cell_force(K, R, X, x)), WithinAbs(0.0, 1e-13 * 1e3 * 20.0));
  }
}

TEST_CASE("linear kinematics does not see that a rotation is rigid", "[corotational]") {
  std::mt19937 generator(42);
  const Material linear{.youngs_modulus = 1.0e3, .poisson_ratio = 0.3};
  const CellVectors X = sample_cell(CellShape::hexahedron, 0.15, generator);
  const CellGeometry geometry = cell_geometry(CellShape::hexahedron, X);
  const CellMatrix K = cell_stiffness(CellShape::hexahedron, geometry, linear);
  const CellVectors x = affine_image(CellShape::hexahedron, turn_about_random_axis(0.5, generator), {0, 0, 0}, X);
  const Eigen::Matrix3d R = cell_rotation(geometry, linear, x);
  CHECK(R == Eigen::Matrix3d::Identity());
  CHECK(largest_force(cell_force(K, R, X, x)) > 1.0);
}

TEST_CASE("with no rotation the force is K u", "[corotational]") {
  std::mt19937 generator(43);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Material linear{.youngs_modulus = 1.0e3, .poisson_ratio = 0.3};
  const CellVectors X = sample_cell(shape, 0.15, generator);
  const CellMatrix K = cell_stiffness(shape, cell_geometry(shape, X), linear);
  const CellVectors u = random_corner_vectors(shape, 0.3, generator);
  const CellVectors force = cell_force(K, Eigen::Matrix3d::Identity(), X, X + u);
  const Eigen::Matrix<double, 24, 1> expected = K * Eigen::Map<const Eigen::Matrix<double, 24, 1>>(u.data());
  CHECK_THAT((Eigen::Map<const Eigen::Matrix<double, 24, 1>>(force.data()) - expected).norm() / expected.norm(),
             WithinAbs(0.0, 1e-14));
}

TEST_CASE("force, stress and rotation follow a superposed rotation", "[corotational][objectivity]") {
  std::mt19937 generator(44);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Dilatation dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  const double angle = GENERATE(0.3, 2.0, 3.141592653589793);
  CAPTURE(int(shape), int(dilatation), angle);
  Material material = corotational_tissue;
  material.dilatation = dilatation;
  for (int trial = 0; trial < 20; ++trial) {
    const CellVectors X = sample_cell(shape, 0.1, generator);
    const CellGeometry geometry = cell_geometry(shape, X);
    const CellMatrix K = cell_stiffness(shape, geometry, material);
    const CellVectors x = X + random_corner_vectors(shape, 0.15, generator);
    const Eigen::Matrix3d turn = turn_about_random_axis(angle, generator);
    const CellVectors turned = affine_image(shape, turn, random_vector(generator), x);

    const Eigen::Matrix3d R = cell_rotation(geometry, material, x);
    const Eigen::Matrix3d R_turned = cell_rotation(geometry, material, turned);
    CHECK_THAT((R_turned - turn * R).cwiseAbs().maxCoeff(), WithinAbs(0.0, 1e-13));

    const CellVectors force = cell_force(K, R, X, x);
    CHECK(largest_force(force) > 1.0);
    CHECK_THAT(largest_force(cell_force(K, R_turned, X, turned) - turn * force) / largest_force(force),
               WithinAbs(0.0, 1e-12));

    const CellVectors local = affine_image(shape, R.transpose(), {0, 0, 0}, x) - X;
    const CellVectors local_turned = affine_image(shape, R_turned.transpose(), {0, 0, 0}, turned) - X;
    const auto stress = quadrature_stress(shape, geometry, material, R, local);
    const auto stress_turned = quadrature_stress(shape, geometry, material, R_turned, local_turned);
    for (int q = 0; q < quadrature_count(shape); ++q)
      CHECK_THAT((stress_turned.col(q) - rotate_stress(turn, stress.col(q))).norm() / stress.norm(),
                 WithinAbs(0.0, 1e-12));
    const Voigt centre = centre_stress(shape, geometry, material, R, local);
    const Voigt centre_turned = centre_stress(shape, geometry, material, R_turned, local_turned);
    CHECK_THAT((centre_turned - rotate_stress(turn, centre)).norm() / stress.norm(), WithinAbs(0.0, 1e-12));
    CHECK_THAT(von_mises(centre_turned), WithinRel(von_mises(centre), 1e-11));
  }
}

TEST_CASE("the force differentiates to R K Rt where the rotation is held", "[corotational]") {
  std::mt19937 generator(45);
  const CellVectors X = sample_cell(CellShape::hexahedron, 0.15, generator);
  const CellMatrix K =
      cell_stiffness(CellShape::hexahedron, cell_geometry(CellShape::hexahedron, X), corotational_tissue);
  const Eigen::Matrix3d R = turn_about_random_axis(1.0, generator);
  CellMatrix turn = CellMatrix::Zero();
  for (int a = 0; a < 8; ++a) turn.block<3, 3>(3 * a, 3 * a) = R;
  const CellMatrix tangent = turn * K * turn.transpose();
  const CellVectors x = X + random_corner_vectors(CellShape::hexahedron, 0.2, generator);
  for (int j = 0; j < 24; ++j) {
    // Linear in x with R held: exact for any step.
    CellVectors step = CellVectors::Zero();
    step.data()[j] = 0.5;
    const CellVectors difference = cell_force(K, R, X, x + step) - cell_force(K, R, X, x - step);
    CHECK_THAT((Eigen::Map<const Eigen::Matrix<double, 24, 1>>(difference.data()) - tangent.col(j)).norm() / K.norm(),
               WithinAbs(0.0, 1e-14));
  }
}

TEST_CASE("forces are those of the stresses, and both give one energy", "[stress]") {
  std::mt19937 generator(46);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Dilatation dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  const double nu = GENERATE(0.0, 0.3, 0.4999);
  CAPTURE(int(shape), int(dilatation), nu);
  const Material material{.youngs_modulus = 50.0, .poisson_ratio = nu, .dilatation = dilatation};
  const CellVectors X = sample_cell(shape, 0.15, generator);
  const CellGeometry geometry = cell_geometry(shape, X);
  const CellMatrix K = cell_stiffness(shape, geometry, material);
  const CellVectors u = random_corner_vectors(shape, 0.1, generator);
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const CellVectors force = cell_force(K, I, X, X + u);
  const auto stress = quadrature_stress(shape, geometry, material, I, u);
  CellVectors from_stress = CellVectors::Zero();
  double energy = 0.0;
  for (int q = 0; q < quadrature_count(shape); ++q) {
    const Voigt s = stress.col(q);
    Eigen::Matrix3d S;
    S << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
    // δε of B-bar: the deviator at the point, the dilatation of the mean.
    const Eigen::Matrix3d pressure = s.head<3>().sum() / 3.0 * I;
    const Gradients& dilatation_gradients =
        dilatation == Dilatation::mean ? geometry.mean_gradients : geometry.gradients[q];
    from_stress += geometry.weights[q] * ((S - pressure) * geometry.gradients[q] + pressure * dilatation_gradients);
    energy += geometry.weights[q] * complementary_product(material, s, s);
  }
  CHECK_THAT((force - from_stress).norm() / force.norm(), WithinAbs(0.0, 1e-13));
  // complementary_product subtracts nearly equal terms as nu tends to one half: round-off over 1 - 2 nu.
  CHECK_THAT(energy, WithinRel(force.cwiseProduct(u).sum(), 1e-14 / (1.0 - 2.0 * nu) + 1e-13));
}

TEST_CASE("a constant strain gives Hooke's stress at every point", "[stress][patch]") {
  std::mt19937 generator(47);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Dilatation dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  const Material material{.youngs_modulus = 50.0, .poisson_ratio = 0.45, .dilatation = dilatation};
  const CellVectors X = sample_cell(shape, 0.15, generator);
  const CellGeometry geometry = cell_geometry(shape, X);
  const Eigen::Matrix3d H = 0.1 * random_matrix(generator);
  const CellVectors u = affine_image(shape, H, random_vector(generator), X);
  const Voigt expected = hooke(material, H);
  const auto stress = quadrature_stress(shape, geometry, material, Eigen::Matrix3d::Identity(), u);
  for (int q = 0; q < quadrature_count(shape); ++q)
    CHECK_THAT((stress.col(q) - expected).norm() / expected.norm(), WithinAbs(0.0, 1e-13));
  const Voigt centre = centre_stress(shape, geometry, material, Eigen::Matrix3d::Identity(), u);
  CHECK_THAT((centre - expected).norm() / expected.norm(), WithinAbs(0.0, 1e-13));
  if (shape == CellShape::tetrahedron) CHECK(stress.rightCols<7>().cwiseAbs().maxCoeff() == 0.0);
}

TEST_CASE("the solid patch test of MacNeal and Harder holds for both dilatations", "[patch]") {
  const Dilatation dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  CAPTURE(int(dilatation));
  const Material material{.youngs_modulus = 1.0e6, .poisson_ratio = 0.25, .dilatation = dilatation};
  const BaseMesh mesh = patch_of_seven();
  REQUIRE(validate(mesh) == "");
  Eigen::Matrix3d H;
  H << 2, 1, 1, 1, 2, 1, 1, 1, 2;
  H *= 0.5e-3;
  Eigen::Matrix<double, 48, 48> K = Eigen::Matrix<double, 48, 48>::Zero();
  for (const auto& cell : mesh.cells) {
    CellVectors X;
    for (int c = 0; c < 8; ++c) X.col(c) = mesh.nodes.col(cell[c]);
    const CellMatrix k = cell_stiffness(CellShape::hexahedron, cell_geometry(CellShape::hexahedron, X), material);
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) K.block<3, 3>(3 * cell[a], 3 * cell[b]) += k.block<3, 3>(3 * a, 3 * b);
  }
  // The outer corners are prescribed, the inner ones found.
  Eigen::Matrix3Xd u = H * mesh.nodes;
  const Eigen::Map<const Eigen::VectorXd> prescribed(u.data(), 24);
  const Eigen::VectorXd inner = K.bottomRightCorner<24, 24>().ldlt().solve(-K.bottomLeftCorner<24, 24>() * prescribed);
  const Eigen::Matrix3Xd expected = u.rightCols<8>();
  u.rightCols<8>() = Eigen::Map<const Eigen::Matrix3Xd>(inner.data(), 3, 8);
  CHECK_THAT((u.rightCols<8>() - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff(),
             WithinAbs(0.0, 1e-12));
  const Voigt stress = (Voigt() << 2000, 2000, 2000, 400, 400, 400).finished();
  for (int cell = 0; cell < 7; ++cell) {
    const CellGeometry geometry = cell_geometry(CellShape::hexahedron, corners_of(mesh, cell, mesh.nodes));
    const auto found = quadrature_stress(CellShape::hexahedron, geometry, material, Eigen::Matrix3d::Identity(),
                                         corners_of(mesh, cell, u));
    CHECK_THAT((found.colwise() - stress).cwiseAbs().maxCoeff() / 2000.0, WithinAbs(0.0, 1e-11));
  }
}

TEST_CASE("inverted, flat and collapsed cells are pushed back by finite forces", "[corotational]") {
  std::mt19937 generator(48);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Eigen::Vector3d squeeze =
      GENERATE(Eigen::Vector3d(1, 1, -1), Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 0),
               Eigen::Vector3d(1, 0.9, -0.2));
  CAPTURE(int(shape), squeeze.transpose());
  const CellVectors X = sample_cell(shape, 0.1, generator);
  const CellGeometry geometry = cell_geometry(shape, X);
  const CellMatrix K = cell_stiffness(shape, geometry, corotational_tissue);
  const CellVectors x = affine_image(shape, squeeze.asDiagonal(), {0, 0, 0}, X);
  const Eigen::Matrix3d R = cell_rotation(geometry, corotational_tissue, x);
  CHECK_THAT(R.determinant(), WithinAbs(1.0, 1e-14));
  const CellVectors force = cell_force(K, R, X, x);
  REQUIRE(force.allFinite());
  // A step towards the rest shape, turned by R, does work against the internal force.
  const CellVectors back = affine_image(shape, R, {0, 0, 0}, X) - x;
  CHECK(force.cwiseProduct(back).sum() < -1e-3 * corotational_tissue.youngs_modulus);
}

TEST_CASE("stress measures agree with principal stresses", "[stress]") {
  std::mt19937 generator(49);
  const Material material{.youngs_modulus = 7.0, .poisson_ratio = 0.2};
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d principal = random_vector(generator);
    const Voigt diagonal = (Voigt() << principal, Eigen::Vector3d::Zero()).finished();
    const Voigt turned = rotate_stress(turn_about_random_axis(1.0, generator), diagonal);
    CHECK(turned.tail<3>().norm() > 1e-3);
    const double a = principal[0] - principal[1], b = principal[1] - principal[2], c = principal[2] - principal[0];
    CHECK_THAT(von_mises(turned), WithinRel(std::sqrt(0.5 * (a * a + b * b + c * c)), 1e-12));
    // σ:C⁻¹:σ by the compliance in principal axes.
    double expected = 0.0;
    for (int i = 0; i < 3; ++i)
      expected += principal[i] * (principal[i] - 0.2 * (principal[(i + 1) % 3] + principal[(i + 2) % 3])) / 7.0;
    CHECK_THAT(complementary_product(material, turned, turned), WithinRel(expected, 1e-12));
  }
  const Voigt shear = (Voigt() << 0, 0, 0, 2, 0, 0).finished();
  CHECK_THAT(von_mises(shear), WithinRel(2.0 * std::sqrt(3.0), 1e-15));
  CHECK_THAT(complementary_product(material, shear, shear), WithinRel(4.0 / material.mu(), 1e-15));
}

TEST_CASE("materials outside the range of elasticity are refused by field, value and range", "[material]") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double E : {0.0, -1.0, nan, infinity}) {
    CAPTURE(E);
    CHECK_THROWS_AS(check(Material{.youngs_modulus = E}), std::invalid_argument);
  }
  for (const double nu : {0.5, 0.6, -1.0, -2.0, nan}) {
    CAPTURE(nu);
    CHECK_THROWS_AS(check(Material{.poisson_ratio = nu}), std::invalid_argument);
  }
  for (const double nu : {-0.999, 0.0, 0.49999999}) CHECK_NOTHROW(check(Material{.poisson_ratio = nu}));
  try {
    check(Material{.poisson_ratio = 0.625});
    FAIL("0.625 was accepted");
  } catch (const std::invalid_argument& error) {
    const std::string message = error.what();
    CHECK(message.find("poisson_ratio is 0.625") != std::string::npos);
    CHECK(message.find("between -1 and 0.5") != std::string::npos);
  }
}
