#include <Eigen/LU>
#include <cmath>

#include "core/adapt/error_estimate.hpp"
#include "core/equilibrium.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/cut_body.hpp"
#include "verification/support/manufactured_solution.hpp"

using namespace finegauge;

namespace {

/// The unit cube up to an oblique plane, as an immersed body on n³ cells. Displacements are prescribed on the cube's
/// faces; the cut is free.
const HalfSpace below_plane{{1.0, 0.6, -0.35}, 0.55};

/// Distance to the plane, times the normal's length.
Jet beyond_plane(const Jets& x) {
  const Eigen::Vector3d& n = below_plane.normal;
  return n.x() * x[0] + n.y() * x[1] + n.z() * x[2] - below_plane.offset;
}

/// Quadratic in the distance to the plane: without stress there, so the cut is free.
ManufacturedSolution fading_solution() {
  return {"fades out at the plane", [](const Jets& x) -> Jets {
            const Jet s = beyond_plane(x), square = 0.1 * s * s;
            return {square * sin(2.0 * x[1] + x[2]), square * cos(2.0 * x[0] - x[2]), square * exp(0.5 * x[1])};
          }};
}

/// Tension along the plane by a strain of a tenth, at nu = 0.3: constant stress.
ManufacturedSolution tension_along_plane() {
  return {"tension along the plane", [](const Jets& x) -> Jets {
            const Eigen::Vector3d t = Eigen::Vector3d(0.6, -1.0, 0.0).normalized();
            const Jet along = t.x() * x[0] + t.y() * x[1];
            return {0.13 * t.x() * along - 0.03 * x[0], 0.13 * t.y() * along - 0.03 * x[1], -0.03 * x[2]};
          }};
}

/// Squares of energy norms over the material [J], of cells that are cut and of those that are not.
struct Errors {
  double cut = 0.0, whole = 0.0;
  double sum() const { return cut + whole; }
};
double effectivity(double estimated, double error) { return std::sqrt(estimated / error); }

struct CutSolution {
  Discretization d;
  Eigen::Matrix3Xd u;
};
/// Whether a cell knows where in it the material lies, or takes it to lie evenly.
enum class Placement { where_it_is, evenly };

CutSolution solve(const ManufacturedSolution& exact, const Material& material, int n, Placement lies) {
  BoxMeshOptions options;
  options.cells = {n, n, n};
  const RefinementForest forest(reached_part(below_plane, box_mesh(options)));
  std::vector<SupportCondition> supports;
  for (const auto& [name, faces] : forest.base().surfaces)
    supports.push_back({name, std::nullopt, [exact](const Eigen::Vector3d& X) { return displacement(exact, X); }});
  Mesh mesh = forest.leaf_mesh();
  mesh.fraction = shares_in(below_plane, mesh);
  if (lies == Placement::where_it_is) mesh.means = means_in(below_plane, mesh);
  CutSolution solution{discretize(forest, std::move(mesh), material, supports), {}};
  const auto force = [&](const Eigen::Vector3d& X) { return body_force(exact, material, X); };
  const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), solution.d.mesh, {}, force, 3);
  EquilibriumOptions direct;
  direct.method = LinearMethod::direct;
  const Equilibrium solved = solve_equilibrium(solution.d, {}, loads, Eigen::Matrix3Xd::Zero(3, loads.cols()), direct);
  REQUIRE(solved.converged);
  solution.u = solved.u;
  return solution;
}

/// By 5³ boxes in every cell, each with its own share, at their centres.
Errors true_errors(const CutSolution& solution, const ManufacturedSolution& exact) {
  const int m = 5;
  Errors errors;
  const Mesh& mesh = solution.d.mesh;
  const Material& material = solution.d.shapes.material();
  CellGeometry scratch;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellVectors X = corner_values(mesh, cell, mesh.nodes), u = corner_values(mesh, cell, solution.u);
    const Eigen::Vector3d size = (X.col(7) - X.col(0)) / m;
    double error = 0.0;
    for (int k = 0; k < m * m * m; ++k) {
      const Eigen::Vector3d place = Eigen::Vector3i(k % m, k / m % m, k / (m * m)).cast<double>();
      const Eigen::Vector3d low = X.col(0) + size.cwiseProduct(place), high = low + size;
      const double share = share_of_box(below_plane, low, high);
      if (share == 0.0) continue;
      const Gradients dN = shape_gradients(mesh.shape, (place.array() + 0.5) / m);
      const Eigen::Matrix3d J = X * dN.transpose(), H = u * dN.transpose() * J.inverse(),
                            strain = 0.5 * (H + H.transpose());
      // With a mean dilatation the pressure is constant in the cell.
      const Eigen::Matrix3d deviator = strain - strain.trace() / 3.0 * Eigen::Matrix3d::Identity();
      const double dilatation =
          material.dilatation == Dilatation::mean
              ? solution.d.shapes.geometry(mesh, cell, scratch).mean_gradients.cwiseProduct(u).sum()
              : strain.trace();
      const Eigen::Matrix3d S =
          2.0 * material.mu() * deviator + material.bulk() * dilatation * Eigen::Matrix3d::Identity();
      const Voigt sigma = (Voigt() << S(0, 0), S(1, 1), S(2, 2), S(0, 1), S(1, 2), S(2, 0)).finished();
      const Voigt off = sigma - stress(exact, material, 0.5 * (low + high));
      error += share * size.prod() * complementary_product(material, off, off);
    }
    (mesh.fraction[cell] < 1.0 ? errors.cut : errors.whole) += error;
  }
  return errors;
}

Errors estimated_errors(const CutSolution& solution, const ErrorEstimate& estimate) {
  Errors errors;
  for (int cell = 0; cell < solution.d.mesh.cell_count(); ++cell)
    (solution.d.mesh.fraction[cell] < 1.0 ? errors.cut : errors.whole) += estimate.eta[cell] * estimate.eta[cell];
  return errors;
}

/// With the cell's own quadrature, as if its material lay evenly.
Errors even_errors(const CutSolution& solution, const Eigen::Matrix<double, 6, Eigen::Dynamic>& nodal_stress) {
  const CellStresses stresses = cell_stresses(solution.d, solution.u);
  const Mesh& mesh = solution.d.mesh;
  Errors errors;
  CellGeometry scratch;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellGeometry& geometry = solution.d.shapes.geometry(mesh, cell, scratch);
    double error = 0.0;
    for (int q = 0; q < 8; ++q) {
      const auto N = shape_functions(mesh.shape, quadrature_point(mesh.shape, q));
      Voigt off = stresses.quadrature.col(8 * cell + q);
      for (int c = 0; c < 8; ++c) off -= N[c] * nodal_stress.col(mesh.cells[cell][c]);
      error +=
          mesh.fraction[cell] * geometry.weights[q] * complementary_product(solution.d.shapes.material(), off, off);
    }
    (mesh.fraction[cell] < 1.0 ? errors.cut : errors.whole) += error;
  }
  return errors;
}

/// Estimated over true error; `plainly`: with recovery and quadrature as in a body that is full, blind to shares.
struct Effectivity {
  double all, cut, plainly_all, plainly_cut, relative_error;
};
Effectivity effectivities(const ManufacturedSolution& exact, int n, Placement lies = Placement::where_it_is,
                          const Material& material = {}) {
  const CutSolution solution = solve(exact, material, n, lies);
  const ErrorEstimate estimate = estimate_error_spr(solution.d, solution.u);
  const Errors truth = true_errors(solution, exact), estimated = estimated_errors(solution, estimate);
  REQUIRE_THAT(estimate.total, WithinRel(std::sqrt(estimated.sum()), 1e-12));
  Discretization blind = solution.d;
  blind.mesh.fraction.clear();
  blind.mesh.means.clear();
  const Errors plain = even_errors(solution, recover_stress_spr(blind, cell_stresses(blind, solution.u)));
  return {effectivity(estimated.sum(), truth.sum()), effectivity(estimated.cut, truth.cut),
          effectivity(plain.sum(), truth.sum()), effectivity(plain.cut, truth.cut),
          std::sqrt(truth.sum()) / estimate.energy_norm};
}

}  // namespace

TEST_CASE("the estimate of a cut body is as good in its cut cells as elsewhere", "[partly filled][error]") {
  // Measured at n = 6, 12: all cells 1.00, 1.00; cut ones 0.95, 0.91. Blind to the material's place and share, the cut
  // cells' error is 0.83, 0.86 of what it is.
  double last = 1.0;
  for (const int n : {6, 12}) {
    const Effectivity found = effectivities(fading_solution(), n);
    CAPTURE(n, found.all, found.cut, found.plainly_all, found.plainly_cut, found.relative_error);
    CHECK(found.all > 0.97);
    CHECK(found.all < 1.03);
    CHECK(found.cut > 0.88);
    CHECK(found.cut < 1.0);
    CHECK(found.plainly_cut > 0.8);
    CHECK(found.plainly_cut < 0.88);
    CHECK(found.relative_error < 0.55 * last);  // first order, the theory's
    CHECK(found.relative_error > 0.1 * last);
    last = found.relative_error;
  }
}

TEST_CASE("constant stress along an oblique cut is exact but for the least stiffness", "[partly filled][error]") {
  // What is left is the stiffness that cells without material keep, and the quadrature of means_in. Where cells take
  // their material to lie evenly, those at the cut are out of balance, and the error falls with the root of h.
  double evenly_before = 0.0;
  for (const int n : {6, 12}) {
    const Effectivity found = effectivities(tension_along_plane(), n);
    const Effectivity evenly = effectivities(tension_along_plane(), n, Placement::evenly);
    CAPTURE(n, found.all, found.cut, found.relative_error, evenly.all, evenly.relative_error);
    CHECK(found.relative_error < 0.004);
    CHECK(found.relative_error > 1e-4);
    CHECK(found.all > 0.9);
    CHECK(found.all < 1.1);
    CHECK(evenly.relative_error > 10.0 * found.relative_error);
    if (evenly_before > 0.0) {
      CHECK(evenly.relative_error / evenly_before > 0.6);
      CHECK(evenly.relative_error / evenly_before < 0.85);
    }
    evenly_before = evenly.relative_error;
  }
}

TEST_CASE("nearly incompressible, the pressure of a cut cell is that of its material", "[partly filled][error]") {
  Material material;
  material.poisson_ratio = 0.49;
  material.dilatation = Dilatation::mean;
  const Effectivity found = effectivities(fading_solution(), 12, Placement::where_it_is, material);
  CAPTURE(found.all, found.cut, found.plainly_cut, found.relative_error);
  CHECK(found.all > 0.9);
  CHECK(found.all < 1.1);
  CHECK(found.cut > 0.8);
  CHECK(found.cut < 1.2);
  // 0.22 with stresses from the dilatation of the whole cell, which the stiffness does not hold.
  CHECK(found.relative_error < 0.12);
  CHECK(found.relative_error > 0.05);
}
