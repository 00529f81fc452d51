#include "core/adapt/error_estimate.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "core/space/assembly.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

using Field = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

BaseMesh bent_box(CellShape shape, double bend, double scale = 1.0) {
  BoxMeshOptions options;
  options.cells = {4, 3, 4};
  options.size = {1.0, 0.8, 1.2};
  options.shape = shape;
  BaseMesh base = box_mesh(options);
  for (Eigen::Index node = 0; node < base.nodes.cols(); ++node) {
    const Eigen::Vector3d x = base.nodes.col(node);
    base.nodes.col(node) =
        scale * (x + bend * Eigen::Vector3d(std::sin(3.0 * x[1]), std::sin(2.0 * x[2]), x[0] * x[1]));
  }
  return base;
}

/// Refined twice within one another, with two templates where the shape allows.
Discretization refined(const BaseMesh& base, const Material& material) {
  RefinementForest forest(base);
  Mesh mesh = forest.leaf_mesh();
  forest.refine(mesh.forest_cell[mesh.cell_count() / 2], {{2, 2, 2}});
  mesh = forest.leaf_mesh();
  const bool hexahedra = base.shape == CellShape::hexahedron;
  forest.refine(mesh.forest_cell[mesh.cell_count() / 2],
                hexahedra ? RefinementTemplate{{2, 3, 1}} : RefinementTemplate{});
  Discretization d = discretize(forest, material, {});
  REQUIRE(d.hanging.hanging_count() > 0);
  return d;
}

/// Values at the nodes that do not hang, interpolated at those that do.
Eigen::Matrix3Xd interpolated(const Discretization& d, const Field& field) {
  Eigen::Matrix3Xd u(3, d.mesh.node_count());
  for (int node = 0; node < d.mesh.node_count(); ++node) u.col(node) = field(d.mesh.nodes.col(node));
  return expand(d.hanging, gather(d.hanging, u));
}

Eigen::Vector3d smooth(const Eigen::Vector3d& x) {
  return 0.1 * Eigen::Vector3d(std::sin(2.0 * x[0]) * x[1], x[0] * x[2] + x[1] * x[1], std::cos(3.0 * x[1]) - x[2]);
}

double relative_distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return (a - b).norm() / b.norm(); }

/// ∫ (σ_h - σ_s):C⁻¹:(σ_h - σ_s) point by point; a tetrahedron by the four points that are exact for quadratics.
Eigen::VectorXd slow_errors_squared(const Discretization& d, const CellStresses& stresses,
                                    const Eigen::Matrix<double, 6, Eigen::Dynamic>& nodal) {
  const Mesh& mesh = d.mesh;
  const bool hexahedra = mesh.shape == CellShape::hexahedron;
  const int stress_points = quadrature_count(mesh.shape);
  Eigen::VectorXd squared = Eigen::VectorXd::Zero(mesh.cell_count());
  CellGeometry scratch;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellGeometry& geometry = d.shapes.geometry(mesh, cell, scratch);
    for (int q = 0; q < (hexahedra ? 8 : 4); ++q) {
      const double a = (5.0 - std::sqrt(5.0)) / 20.0;
      Eigen::Vector3d xi = Eigen::Vector3d::Constant(a);
      if (q > 0) xi[(q - 1) % 3] = 1.0 - 3.0 * a;
      if (hexahedra) xi = quadrature_point(mesh.shape, q);
      const auto N = shape_functions(mesh.shape, xi);
      Voigt difference = stresses.quadrature.col(stress_points * cell + (hexahedra ? q : 0));
      for (int c = 0; c < corner_count(mesh.shape); ++c) difference -= N[c] * nodal.col(mesh.cells[cell][c]);
      squared[cell] += (hexahedra ? geometry.weights[q] : geometry.volume / 4.0) *
                       complementary_product(d.shapes.material(), difference, difference);
    }
  }
  return squared;
}

}  // namespace

TEST_CASE("a constant stress has no error on any refined mesh", "[estimate][patch]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  Material material;
  material.dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  material.poisson_ratio = GENERATE(0.0, 0.3, 0.4999);
  const Discretization d = refined(bent_box(shape, 0.1), material);
  Eigen::Matrix3d gradient;
  gradient << 1.0, 0.3, -0.2, 0.1, -0.7, 0.4, 0.5, 0.2, 0.6;
  const ErrorEstimate estimate =
      estimate_error_spr(d, interpolated(d, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return gradient * x; }));
  CHECK(estimate.energy_norm > 0.1);
  CHECK(estimate.relative < 1e-11);  // round-off, times the stiffness ratio at nu -> 1/2
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell)
    CHECK_THAT(estimate.direction.col(cell).sum(), WithinAbs(1.0, 1e-12));
}

TEST_CASE("a body at rest has neither energy nor error", "[estimate]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Discretization d = refined(bent_box(shape, 0.1), Material{});
  const ErrorEstimate estimate = estimate_error_spr(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
  CHECK(estimate.total == 0.0);
  CHECK(estimate.relative == 0.0);
  CHECK(estimate.eta.isZero(0.0));
  CHECK(estimate.direction.isApproxToConstant(1.0 / 3.0));
}

TEST_CASE("the estimate is the sum over its quadrature points", "[estimate]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  Material material;
  material.youngs_modulus = 2.5e3;
  material.dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  material.kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  const Discretization d = refined(bent_box(shape, 0.1), material);
  const Eigen::Matrix3Xd u = interpolated(d, smooth);
  const ErrorEstimate estimate = estimate_error_spr(d, u);
  const CellStresses stresses = cell_stresses(d, u);
  const Eigen::VectorXd squared = slow_errors_squared(d, stresses, recover_stress_spr(d, stresses));
  CHECK(estimate.relative > 0.01);
  CHECK(relative_distance(estimate.eta.cwiseAbs2(), squared) < 1e-12);
  CHECK_THAT(estimate.total, WithinRel(std::sqrt(squared.sum()), 1e-12));
  CHECK_THAT(estimate.relative, WithinRel(estimate.total / estimate.energy_norm, 1e-14));
  CHECK_THAT(estimate.energy_norm * estimate.energy_norm, WithinRel(strain_energy_product(d, u), 1e-11));
}

TEST_CASE("bending of the strain along one axis is estimated in closed form, and along that axis", "[estimate]") {
  // u_i = x_a²: the strain is linear in x_a and constant in each cell of the interpolant, so that the recovered stress
  // is exact and η_e² = modulus · (2 h / √12)² V, the modulus lambda + 2 mu for stretching and mu for shearing.
  const int axis = GENERATE(0, 1, 2), component = GENERATE(0, 1, 2);
  const Eigen::Matrix3d turned = GENERATE(false, true)
                                     ? Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -1, 2).normalized()).toRotationMatrix()
                                     : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  BoxMeshOptions options;
  options.cells = {4, 3, 5};
  options.size = {2.0, 0.3, 1.0};
  BaseMesh base = box_mesh(options);
  base.nodes = (turned * base.nodes).eval();
  const Material material;
  const Discretization d = discretize(RefinementForest(base), material, {});
  const ErrorEstimate estimate =
      estimate_error_spr(d, interpolated(d, [&](const Eigen::Vector3d& X) -> Eigen::Vector3d {
                           const Eigen::Vector3d x = turned.transpose() * X;
                           return x[axis] * x[axis] * turned.col(component);
                         }));
  const Eigen::Vector3d h(2.0 / 4, 0.3 / 3, 1.0 / 5);
  const double modulus = axis == component ? material.lambda() + 2.0 * material.mu() : material.mu();
  const double eta = std::sqrt(modulus * h[axis] * h[axis] / 3.0 * h.prod());
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    CHECK_THAT(estimate.eta[cell], WithinRel(eta, 1e-9));
    CHECK_THAT(estimate.direction(axis, cell), WithinAbs(1.0, 1e-9));
  }
}

TEST_CASE("the estimate does not change under a superposed rigid motion", "[estimate][corotational]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  Material material;
  material.kinematics = Kinematics::corotational;
  material.dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  const double angle = GENERATE(0.5, 3.0, 3.14159265358979);
  const Discretization d = refined(bent_box(shape, 0.1), material);
  const Eigen::Matrix3Xd u = interpolated(d, smooth);
  const Eigen::Matrix3d Q = Eigen::AngleAxisd(angle, Eigen::Vector3d(2, -1, 1).normalized()).toRotationMatrix();
  Eigen::Matrix3Xd moved = Q * (d.mesh.nodes + u);
  moved.colwise() += Eigen::Vector3d(3.0, -2.0, 1.0);
  const ErrorEstimate before = estimate_error_spr(d, u);
  const ErrorEstimate after = estimate_error_spr(d, moved - d.mesh.nodes);
  CHECK(before.relative > 0.01);
  CHECK_THAT(after.relative, WithinRel(before.relative, 1e-10));
  CHECK(relative_distance(after.eta, before.eta) < 1e-10);
  CHECK((after.direction - before.direction).cwiseAbs().maxCoeff() < 1e-8);
  double stress_error = 0.0;
  for (int node = 0; node < d.mesh.node_count(); ++node)
    stress_error =
        std::max(stress_error, (after.nodal_stress.col(node) - rotate_stress(Q, before.nodal_stress.col(node))).norm());
  CHECK(stress_error < 1e-10 * before.nodal_stress.norm());
}

TEST_CASE("metres or millimetres, the estimate is the same", "[estimate]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  Material in_metres, in_millimetres;
  in_millimetres.youngs_modulus = in_metres.youngs_modulus * 1e-6;  // N/mm²
  const Discretization metres = refined(bent_box(shape, 0.1), in_metres);
  const Discretization millimetres = refined(bent_box(shape, 0.1, 1e3), in_millimetres);
  const Eigen::Matrix3Xd u = interpolated(metres, smooth);
  const ErrorEstimate a = estimate_error_spr(metres, u), b = estimate_error_spr(millimetres, 1e3 * u);
  CHECK(a.relative > 0.01);
  CHECK_THAT(b.relative, WithinRel(a.relative, 1e-10));
  CHECK_THAT(b.total * b.total, WithinRel(1e3 * a.total * a.total, 1e-10));  // N mm
  CHECK((a.direction - b.direction).cwiseAbs().maxCoeff() < 1e-8);
}

TEST_CASE("under loads alone the estimate counts what the solution lacks of its amplitude", "[estimate]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  Material material;
  material.kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  Discretization d = refined(bent_box(shape, 0.1), material);
  const double size = GENERATE(1.0, 30.0);  // of the error beside the energy
  const Eigen::Matrix3Xd u =
      interpolated(d, [&](const Eigen::Vector3d& X) -> Eigen::Vector3d { return 0.01 * (X + size * smooth(X)); });
  const ErrorEstimate without = estimate_error(d, u, Estimator::spr_edges);
  const double plain = estimate_error_spr(d, u).total;
  d.driven_by_loads = true;
  const ErrorEstimate loaded = estimate_error(d, u, Estimator::spr_edges);
  CHECK(estimate_error_spr(d, u).total == plain);
  CHECK_THAT(loaded.eta.norm(), WithinRel(loaded.total, 1e-14));
  if (material.kinematics == Kinematics::corotational) {
    CHECK(loaded.total == without.total);
    return;
  }
  // ‖e‖² = est² (1 + ‖e‖²/‖u_h‖²), the equation that the closed form solves.
  const double energy = loaded.energy_norm * loaded.energy_norm;
  CHECK(without.relative > 0.01);
  CHECK(loaded.relative > without.relative);
  CHECK_THAT(loaded.total * loaded.total,
             WithinRel(without.total * without.total * (1.0 + loaded.total * loaded.total / energy), 1e-12));
  CHECK(relative_distance(loaded.eta / loaded.total, without.eta / without.total) < 1e-12);
  const ErrorEstimate at_rest = estimate_error(d, Eigen::Matrix3Xd::Zero(3, u.cols()), Estimator::spr_edges);
  CHECK(at_rest.total == 0.0);
  CHECK(at_rest.relative == 0.0);
}

TEST_CASE("the amplitude that a solution lacks is bounded where it is nothing but error", "[estimate]") {
  Discretization d = refined(bent_box(CellShape::tetrahedron, 0.1), Material{});
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  for (int node = 0; node < d.mesh.node_count(); ++node)
    if (!d.hanging.hangs(node)) u.col(node) = Eigen::Vector3d(node % 2, node % 3, node % 5);  // noise
  u = expand(d.hanging, gather(d.hanging, u));
  const double without = estimate_error(d, u, Estimator::spr_edges).total;
  d.driven_by_loads = true;
  CHECK_THAT(estimate_error(d, u, Estimator::spr_edges).total, WithinRel(2.0 * without, 1e-12));
}

TEST_CASE("tetrahedra far from a singular edge count a share for what the edge takes from the whole field",
          "[estimate]") {
  BoxMeshOptions options;
  options.cells = {6, 6, 3};
  options.shape = CellShape::tetrahedron;
  options.removed = RemovedBlock{{3, 0, 0}, {6, 3, 3}};
  const Discretization notched = refined(box_mesh(options), Material{});
  // Of λ = 0.544 (Williams 1952) in 64ths.
  CHECK_THAT(pollution_share(0.5390625), WithinRel(0.1 * std::exp(-0.390625), 1e-14));
  CHECK(pollution_share(0.3) == pollution_share(0.5));
  Discretization plain = notched;
  std::ranges::fill(plain.singular_edge, SingularEdge{});
  const auto at_notch = [&](double power) {  // the more, the less lies at the notch
    return interpolated(notched, [&](const Eigen::Vector3d& X) -> Eigen::Vector3d {
      const double r = (X - Eigen::Vector3d(0.5, 0.5, X.z())).norm();
      return {0.0, 0.0, std::pow(r, power) * std::sin(2.0 * X.x())};
    });
  };
  for (const double power : {0.6, 6.0}) {
    const Eigen::Matrix3Xd u = at_notch(power);
    const ErrorEstimate weighted = estimate_error(notched, u, Estimator::spr_edges),
                        raw = estimate_error(plain, u, Estimator::spr_edges);
    double near = 0.0, far = 0.0;
    for (int cell = 0; cell < notched.mesh.cell_count(); ++cell)
      (notched.singular_edge[cell] ? near : far) +=
          notched.singular_edge[cell] ? weighted.eta[cell] * weighted.eta[cell] : raw.eta[cell] * raw.eta[cell];
    const double share = pollution_share(0.5390625) * std::min(1.0, most_pollution_of_near * near / far);
    INFO(power << " near " << near << " far " << far);
    CHECK((power > 1.0) == (most_pollution_of_near * near < far));
    for (int cell = 0; cell < notched.mesh.cell_count(); ++cell)
      if (!notched.singular_edge[cell])
        CHECK_THAT(weighted.eta[cell], WithinRel(raw.eta[cell] * std::sqrt(1.0 + share), 1e-10));
  }
  // Without an error there is nothing to share.
  const Eigen::Matrix3Xd at_rest = Eigen::Matrix3Xd::Zero(3, notched.mesh.node_count());
  CHECK(estimate_error(notched, at_rest, Estimator::spr_edges).eta.isZero(0.0));
}
