#include "verification/support/field_errors.hpp"

#include <cmath>

#include "verification/support/catch.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

Jets quadratic(const Jets& x) { return {x[0] * x[0], 0.0, 0.0}; }
Jets sheared_stretch(const Jets& x) { return {x[0] * x[1], 0.0, 0.0}; }

constexpr double h[3] = {2.0 / 4.0, 0.6 / 3.0, 1.0 / 5.0};
constexpr double box_volume = 2.0 * 0.6 * 1.0;

Discretization box(const Material& material) {
  BoxMeshOptions options;
  options.cells = {4, 3, 5};
  options.size = {2.0, 0.6, 1.0};
  return discretize(RefinementForest(box_mesh(options)), material, {});
}

/// Errors of the nodal interpolant, with the exact stress at the nodes as the recovered one.
FieldErrors of_interpolant(const Discretization& d, const ManufacturedSolution& exact) {
  Eigen::Matrix3Xd u(3, d.mesh.node_count());
  Eigen::Matrix<double, 6, Eigen::Dynamic> nodal_stress(6, d.mesh.node_count());
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    u.col(node) = displacement(exact, d.mesh.nodes.col(node));
    nodal_stress.col(node) = stress(exact, d.shapes.material(), d.mesh.nodes.col(node));
  }
  return field_errors(d, exact, u, nodal_stress);
}

}  // namespace

TEST_CASE("the interpolant of x² has its closed errors", "[field_errors]") {
  Material material;
  material.dilatation = GENERATE(Dilatation::standard, Dilatation::mean);  // the strain is constant in each cell
  const Discretization d = box(material);
  const FieldErrors errors = of_interpolant(d, {"x²", quadratic});
  // u_h - u = s (h - s), strain error h - 2s: ∫ over a cell of length h along x, times the rest of its volume.
  const double modulus = material.lambda() + 2.0 * material.mu();
  CHECK_THAT(errors.displacement, WithinRel(h[0] * h[0] * std::sqrt(box_volume / 30.0), 1e-12));
  CHECK_THAT(errors.displacement_norm, WithinRel(std::sqrt(32.0 / 5.0 * 0.6), 1e-12));
  CHECK_THAT(errors.energy, WithinRel(h[0] * std::sqrt(modulus * box_volume / 3.0), 1e-12));
  CHECK_THAT(errors.energy_norm, WithinRel(std::sqrt(modulus * 4.0 * 8.0 / 3.0 * 0.6), 1e-12));
  CHECK(errors.nodal == 0.0);
  CHECK(errors.nodal_norm > 0.0);
  CHECK(errors.recovered_stress < 1e-12 * errors.energy_norm);  // a linear stress is interpolated exactly
  CHECK_THAT(errors.cell_energy.norm(), WithinRel(errors.energy, 1e-12));
}

TEST_CASE("the stress of the mean dilatation is off by the bulk modulus times what it averages", "[field_errors]") {
  Material material;
  material.poisson_ratio = 0.45;
  const ManufacturedSolution exact{"x y", sheared_stretch};  // trilinear, div u = y
  CHECK(of_interpolant(box(material), exact).energy < 1e-12);
  material.dilatation = Dilatation::mean;
  const FieldErrors errors = of_interpolant(box(material), exact);
  CHECK_THAT(errors.energy, WithinRel(std::sqrt(material.bulk() * h[1] * h[1] / 12.0 * box_volume), 1e-10));
}

TEST_CASE("on distorted cells the energy of x² is integrated exactly", "[field_errors]") {
  std::mt19937 generator(5);
  BoxMeshOptions options;
  options.cells = {4, 3, 5};
  options.size = {2.0, 0.6, 1.0};
  const Discretization d = discretize(RefinementForest(distorted_box(options, 0.2, generator)), {}, {});
  const int nodes = d.mesh.node_count();
  const FieldErrors errors = field_errors(d, {"x²", quadratic}, Eigen::Matrix3Xd::Zero(3, nodes),
                                          Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, nodes));
  const Material& material = d.shapes.material();
  // ∫ (lambda + 2 mu) (2 x)² over the box, whose planes stay, in cells whose shares of it all differ.
  const double energy = std::sqrt((material.lambda() + 2.0 * material.mu()) * 4.0 * 8.0 / 3.0 * 0.6);
  CHECK_THAT(errors.energy_norm, WithinRel(energy, 1e-12));
  CHECK_THAT(errors.energy, WithinRel(energy, 1e-12));
  CHECK_THAT(errors.recovered_stress, WithinRel(energy, 1e-12));
  CHECK_THAT(errors.displacement, WithinRel(std::sqrt(32.0 / 5.0 * 0.6), 1e-12));
}

TEST_CASE("without a solution all of it is error", "[field_errors]") {
  const Discretization d = box(Material{});
  const int nodes = d.mesh.node_count();
  const FieldErrors errors = field_errors(d, smooth_solution(), Eigen::Matrix3Xd::Zero(3, nodes),
                                          Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, nodes));
  CHECK(errors.energy_norm > 0.0);
  CHECK_THAT(errors.displacement, WithinRel(errors.displacement_norm, 1e-14));
  CHECK_THAT(errors.energy, WithinRel(errors.energy_norm, 1e-14));
  CHECK_THAT(errors.recovered_stress, WithinRel(errors.energy_norm, 1e-14));
  CHECK_THAT(errors.nodal, WithinRel(errors.nodal_norm, 1e-14));
}
