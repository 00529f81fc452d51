#include "verification/support/exact_field.hpp"

#include <numbers>

#include "verification/support/catch.hpp"

using namespace finegauge;

// The fields are written down as complex potentials: stress and displacement apart. That they belong together, are in
// equilibrium and leave their faces free or at rest is checked by differences here, and is all that the ladder needs.

namespace {

using std::numbers::pi;

Eigen::Matrix3d stress_of_displacement(const ExactField& field, const Material& material, const Eigen::Vector3d& X) {
  constexpr double h = 1e-5;
  Eigen::Matrix3d gradient;
  for (int j = 0; j < 3; ++j)
    gradient.col(j) =
        (field.displacement(X + h * Eigen::Vector3d::Unit(j)) - field.displacement(X - h * Eigen::Vector3d::Unit(j))) /
        (2.0 * h);
  return material.mu() * (gradient + gradient.transpose()) +
         material.lambda() * gradient.trace() * Eigen::Matrix3d::Identity();
}

Eigen::Vector3d divergence(const ExactField& field, const Eigen::Vector3d& X) {
  constexpr double h = 1e-5;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int j = 0; j < 3; ++j)
    sum += (stress_tensor(field.stress(X + h * Eigen::Vector3d::Unit(j))).col(j) -
            stress_tensor(field.stress(X - h * Eigen::Vector3d::Unit(j))).col(j)) /
           (2.0 * h);
  return sum;
}

Eigen::Vector3d at(double angle, double r = 0.7) { return {r * std::cos(angle), r * std::sin(angle), 0.3}; }

void check_elastic(const ExactField& field, const Material& material, double angle) {
  CAPTURE(field.name, angle);
  const Eigen::Vector3d X = at(angle);
  const double size = stress_tensor(field.stress(X)).norm();
  CHECK((stress_tensor(field.stress(X)) - stress_of_displacement(field, material, X)).norm() < 1e-8 * size);
  CHECK(divergence(field, X).norm() < 1e-8 * size);
}

Eigen::Vector3d traction(const ExactField& field, double face_angle) {
  return stress_tensor(field.stress(at(face_angle))) *
         Eigen::Vector3d(-std::sin(face_angle), std::cos(face_angle), 0.0);
}

}  // namespace

TEST_CASE("exponents of a right-angled notch and of a crack are the literature's", "[exact_field]") {
  // Williams 1952; digits by bisection of sin(3πλ/2) = ±λ.
  CHECK_THAT(corner_exponent(CornerMode::opening, 1.5 * pi), WithinAbs(0.54448373678246, 1e-12));
  CHECK_THAT(corner_exponent(CornerMode::sliding, 1.5 * pi), WithinAbs(0.90852918984610, 1e-12));
  CHECK_THAT(corner_exponent(CornerMode::opening, 2.0 * pi), WithinAbs(0.5, 1e-12));
  CHECK_THROWS_AS(corner_exponent(CornerMode::opening, 0.5 * pi), std::invalid_argument);
  CHECK_THROWS_AS(corner_exponent(CornerMode::sliding, 1.1 * pi), std::invalid_argument);
}

TEST_CASE("the field of a notch is elastic, in equilibrium and leaves its faces free", "[exact_field]") {
  const CornerMode mode = GENERATE(CornerMode::opening, CornerMode::sliding);
  Material material;
  const ExactField field = corner_field(mode, 1.5 * pi, {0.0, 0.0}, 0.75 * pi, material);
  for (const double angle : {0.1, 1.0, 2.5, 4.0}) check_elastic(field, material, angle);
  for (const double face : {1e-9, 1.5 * pi - 1e-9})
    CHECK(traction(field, face).norm() < 1e-7 * stress_tensor(field.stress(at(0.75 * pi))).norm());
}

TEST_CASE("the field at a clamped rim is elastic, at rest on one face and free on the other", "[exact_field]") {
  Material material;
  material.poisson_ratio = GENERATE(0.3, 0.4);
  double exponent = 0.0;
  const ExactField field = clamped_corner_field(0.0, 0.5 * pi, {0.0, 0.0}, material, &exponent);
  // sin² λω = ((κ + 1)² - 4 λ² sin² ω) / 4κ (Williams 1952), κ = 3 - 4 nu.
  const double kappa = 3.0 - 4.0 * material.poisson_ratio;
  const double sine = std::sin(0.5 * pi * exponent);
  CHECK_THAT(sine * sine,
             WithinAbs(((kappa + 1.0) * (kappa + 1.0) - 4.0 * exponent * exponent) / (4.0 * kappa), 1e-10));
  for (const double angle : {0.2, 0.8, 1.4}) check_elastic(field, material, angle);
  CHECK(traction(field, 0.0).norm() < 1e-9 * stress_tensor(field.stress(at(0.25 * pi))).norm());
  CHECK(field.displacement(at(0.5 * pi)).norm() < 1e-9 * field.displacement(at(0.25 * pi)).norm());
}

TEST_CASE("a field that is singular at an edge has the same energy integrated over tetrahedra as over hexahedra",
          "[exact_field]") {
  BoxMeshOptions options;
  options.origin = {-1.0, -1.0, 0.0};
  options.size = {2.0, 2.0, 0.5};
  options.cells = {4, 4, 1};
  const bool turned = GENERATE(false, true);  // diagonals of the lattice then pass the edge by
  options.removed = turned ? RemovedBlock{{2, 2, 0}, {4, 4, 1}} : RemovedBlock{{2, 0, 0}, {4, 2, 1}};
  const ExactField field =
      corner_field(CornerMode::opening, 1.5 * pi, {0.0, 0.0}, (turned ? 1.25 : 0.75) * pi, Material{});
  std::array<double, 2> energy_norm{};
  for (const CellShape shape : {CellShape::hexahedron, CellShape::tetrahedron}) {
    options.shape = shape;
    const Discretization d = discretize(RefinementForest(box_mesh(options)), Material{}, {});
    const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
    const Eigen::Matrix<double, 6, Eigen::Dynamic> no_stress =
        Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, d.mesh.node_count());
    const TrueError error = true_error(d, field, rest, no_stress, 8);
    // Of no displacement the error is the field itself.
    CHECK_THAT(error.total / error.energy_norm, WithinAbs(1.0, 1e-12));
    CHECK_THAT(error.recovered / error.energy_norm, WithinAbs(1.0, 1e-12));
    energy_norm[shape == CellShape::tetrahedron] = error.energy_norm;
  }
  CHECK_THAT(energy_norm[1] / energy_norm[0], WithinAbs(1.0, 1e-5));
}
