#include "core/adapt/stress_recovery.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <set>

#include "core/adapt/patch_polynomial.hpp"
#include "core/static_step.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

using StressField = std::function<Voigt(const Eigen::Vector3d&)>;

struct RecoveryCase {
  std::array<int, 3> cells = {4, 4, 4};
  CellShape shape = CellShape::hexahedron;
  Eigen::Vector3d size = Eigen::Vector3d::Ones();
  double perturbation = 0.0;  ///< of the nodes, as a share of the smallest cell edge
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  std::vector<RefinementTemplate> refinements = {};  ///< each refines the leaf in the middle of the mesh's list, twice
};

Discretization discretization_of(const RecoveryCase& c) {
  BoxMeshOptions options;
  options.size = c.size;
  options.cells = c.cells;
  options.shape = c.shape;
  BaseMesh base = box_mesh(options);
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(-c.perturbation, c.perturbation);
  const double edge = std::min({c.size[0] / c.cells[0], c.size[1] / c.cells[1], c.size[2] / c.cells[2]});
  for (Eigen::Index node = 0; node < base.nodes.cols(); ++node) {
    Eigen::Vector3d shift;
    for (double& component : shift) component = edge * uniform(generator);
    base.nodes.col(node) = c.turned * (base.nodes.col(node) + shift);
  }
  RefinementForest forest(base);
  for (const RefinementTemplate& refinement : c.refinements)
    for (const int part : {2, 3}) {
      const Mesh mesh = forest.leaf_mesh();
      forest.refine(mesh.forest_cell[mesh.cell_count() / part], refinement);
    }
  return discretize(forest, Material{}, {});
}

Eigen::Vector3d centre_of(const Mesh& mesh, int cell) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int c = 0; c < corner_count(mesh.shape); ++c)
    centre += mesh.nodes.col(mesh.cells[cell][c]) / corner_count(mesh.shape);
  return centre;
}

CellStresses centre_stresses(const Mesh& mesh, const StressField& field) {
  CellStresses stresses;
  stresses.centre.resize(6, mesh.cell_count());
  for (int cell = 0; cell < mesh.cell_count(); ++cell) stresses.centre.col(cell) = field(centre_of(mesh, cell));
  return stresses;
}

/// Largest difference at a node over the largest value at one.
double recovery_error(const Discretization& d, const StressField& field) {
  const VoigtColumns recovered = recover_stress_spr(d, centre_stresses(d.mesh, field));
  double error = 0.0, scale = 0.0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const Voigt exact = field(d.mesh.nodes.col(node));
    error = std::max(error, (recovered.col(node) - exact).cwiseAbs().maxCoeff());
    scale = std::max(scale, exact.cwiseAbs().maxCoeff());
  }
  return error / scale;
}

StressField linear_stress_field(const Eigen::Vector3d& size) {
  Eigen::Matrix<double, 6, 3> slopes;
  slopes << 1, 2, 3, -1, 4, 1, 2, -2, 5, 3, 1, -1, 0.5, 2, 1, -3, 1, 2;
  const Eigen::Matrix<double, 6, 3> scaled = slopes * size.cwiseInverse().asDiagonal();
  return [scaled](const Eigen::Vector3d& X) -> Voigt { return Voigt::Constant(7.0) + scaled * X; };
}

/// All eight terms in the coordinates of the box before it was turned.
StressField trilinear_field(const RecoveryCase& c) {
  return [c](const Eigen::Vector3d& X) -> Voigt {
    const Eigen::Vector3d x = (c.turned.transpose() * X).cwiseQuotient(c.size);
    Voigt sigma;
    for (int k = 0; k < 6; ++k)
      sigma[k] = 1.0 + k + x[0] - 2.0 * x[1] + k * x[2] + 3.0 * x[0] * x[1] - k * x[1] * x[2] + x[2] * x[0] +
                 (4.0 - k) * x[0] * x[1] * x[2];
    return sigma;
  };
}

Eigen::Matrix3d some_turn() {
  return Eigen::AngleAxisd(0.6, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
}

// Fits are exact up to round-off times the square root of the largest condition allowed, and boundary nodes
// extrapolate by a few cells.
constexpr double recovery_round_off = 1e-11;

}  // namespace

TEST_CASE("a linear stress is recovered exactly at every node", "[recovery]") {
  const RecoveryCase c = GENERATE(
      RecoveryCase{}, RecoveryCase{.perturbation = 0.25}, RecoveryCase{.size = {1.0, 100.0, 10.0}},
      RecoveryCase{.size = {100.0, 1.0, 10.0}, .turned = some_turn()},
      RecoveryCase{.cells = {3, 3, 3}, .shape = CellShape::tetrahedron},
      RecoveryCase{
          .cells = {3, 4, 2}, .shape = CellShape::tetrahedron, .perturbation = 0.1, .refinements = {{{2, 2, 2}}}},
      RecoveryCase{.refinements = {{{2, 2, 2}}, {{2, 2, 2}}}},
      RecoveryCase{.perturbation = 0.1, .refinements = {{{3, 3, 3}}, {{2, 3, 3}}, {{2, 2, 1}}}},
      RecoveryCase{.size = {1.0, 50.0, 1.0}, .refinements = {{{2, 2, 2}}, {{4, 1, 1}}}},
      RecoveryCase{.cells = {2, 2, 1}}, RecoveryCase{.cells = {2, 2, 2}});
  const Discretization d = discretization_of(c);
  CAPTURE(c.cells, c.perturbation, c.refinements.size(), d.hanging.hanging_count());
  if (!c.refinements.empty()) REQUIRE(d.hanging.hanging_count() > 0);
  if (c.cells == std::array{2, 2, 1}) {
    // One layer has no inner node, and its centres lie in a plane: the mean of a patch is all that they determine.
    CHECK(recovery_error(d, linear_stress_field(c.size)) > 0.01);
    CHECK(recovery_error(d, [](const Eigen::Vector3d&) -> Voigt { return Voigt::Constant(2.0); }) < recovery_round_off);
  } else {
    CHECK(recovery_error(d, linear_stress_field(c.size)) < recovery_round_off);
  }
}

TEST_CASE("the stress of a quadratic displacement is recovered exactly on boxes", "[recovery]") {
  // At the centre of a box the gradient of the trilinear interpolant of a quadratic function is exact.
  const RecoveryCase c = GENERATE(RecoveryCase{}, RecoveryCase{.size = {1.0, 3.0, 20.0}});
  const Discretization d = discretization_of(c);
  Eigen::Matrix3Xd u(3, d.mesh.node_count());
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const Eigen::Vector3d x = d.mesh.nodes.col(node);
    u.col(node) << x[0] * x[0] + x[1] * x[2], x[0] * x[1] - x[1] * x[1], 2.0 * x[2] * x[2] + x[0] * x[2];
  }
  const VoigtColumns recovered = recover_stress_spr(d, cell_stresses(d, u));
  const Material material;
  double error = 0.0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const Eigen::Vector3d x = d.mesh.nodes.col(node);
    Eigen::Matrix3d gradient;
    gradient << 2.0 * x[0], x[2], x[1], x[1], x[0] - 2.0 * x[1], 0.0, x[2], 0.0, 4.0 * x[2] + x[0];
    const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
    const Eigen::Matrix3d sigma =
        2.0 * material.mu() * strain + material.lambda() * strain.trace() * Eigen::Matrix3d::Identity();
    Voigt exact;
    exact << sigma(0, 0), sigma(1, 1), sigma(2, 2), sigma(0, 1), sigma(1, 2), sigma(2, 0);
    error = std::max(error, (recovered.col(node) - exact).cwiseAbs().maxCoeff());
  }
  CHECK(error / recovered.cwiseAbs().maxCoeff() < recovery_round_off);
}

TEST_CASE("all eight terms are recovered on a regular lattice, however turned and stretched", "[recovery]") {
  const RecoveryCase c =
      GENERATE(RecoveryCase{}, RecoveryCase{.size = {1.0, 100.0, 10.0}}, RecoveryCase{.turned = some_turn()},
               RecoveryCase{.size = {1.0, 100.0, 10.0}, .turned = some_turn()});
  CHECK(recovery_error(discretization_of(c), trilinear_field(c)) < 1e-10);
}

TEST_CASE("on a lattice the fit without a system equals the least-squares fit", "[recovery]") {
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Eigen::Matrix3d axes = some_turn() * Eigen::Vector3d(1.0, 0.02, 0.3).asDiagonal();
  std::array<int, 8> octants = {3, 0, 5, 1, 7, 2, 6, 4};  // where in the list of cells each octant stands
  Eigen::Matrix3Xd centres(3, 8);
  VoigtColumns values(6, 8);
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d y(k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, k & 4 ? 1.0 : -1.0);
    centres.col(octants[k]) = Eigen::Vector3d(5.0, 6.0, 7.0) + axes * y;
    for (double& component : values.col(octants[k])) component = uniform(generator);
  }
  const OctantFit fast = fit_octants(octants, centres, values);
  REQUIRE(fast.is_lattice);
  const PatchPolynomial general = fit_patch(octants, centres, values, axes, PatchBasis::trilinear);
  REQUIRE(general.basis == PatchBasis::trilinear);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d X =
        Eigen::Vector3d(5.0, 6.0, 7.0) + axes * Eigen::Vector3d(uniform(generator), uniform(generator), 2.0);
    CHECK((fast.polynomial(X) - general(X)).norm() < 1e-12 * general(X).norm() + 1e-12);
  }
  // One centre moved by a thousandth of an edge: no lattice any more.
  centres(1, 0) += 1e-3 * axes.col(1).norm();
  CHECK_FALSE(fit_octants(octants, centres, values).is_lattice);
}

TEST_CASE("a patch that does not determine eight terms drops to four and then to one", "[recovery]") {
  // Turned by 45 degrees against the axes, xy vanishes at all eight centres. The smaller the angle that is missing, the
  // worse the condition: about (4 / sin 2a)².
  const auto fit_turned = [](double missing, double thickness) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(std::numbers::pi / 4.0 - missing, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Matrix3Xd centres(3, 8);
    for (int k = 0; k < 8; ++k)
      centres.col(k) = turn * Eigen::Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? thickness : -thickness);
    VoigtColumns values(6, 8);
    const StressField field = linear_stress_field(Eigen::Vector3d::Ones());
    for (int k = 0; k < 8; ++k) values.col(k) = field(centres.col(k));
    const std::array<int, 8> cells = {0, 1, 2, 3, 4, 5, 6, 7};
    const PatchPolynomial p = fit_patch(cells, centres, values, Eigen::Matrix3d::Identity(), PatchBasis::trilinear);
    const Eigen::Vector3d X(0.3, -0.4, 0.2);
    if (p.basis != PatchBasis::mean) CHECK((p(X) - field(X)).norm() < 1e-10 * field(X).norm());
    return p.basis;
  };
  CHECK(fit_turned(std::numbers::pi / 4.0, 1.0) == PatchBasis::trilinear);
  CHECK(fit_turned(0.1, 1.0) == PatchBasis::trilinear);
  CHECK(fit_turned(1e-3, 1.0) == PatchBasis::linear);
  CHECK(fit_turned(0.0, 1.0) == PatchBasis::linear);
  CHECK(fit_turned(0.0, 1e-3) == PatchBasis::linear);  // thin is not flat: each axis has its own scale
  CHECK(fit_turned(0.0, 0.0) == PatchBasis::mean);
}

TEST_CASE("a boundary node takes the mean of the polynomials of the inner nodes beside it", "[recovery]") {
  const RecoveryCase c =
      GENERATE(RecoveryCase{.perturbation = 0.2}, RecoveryCase{.perturbation = 0.2, .refinements = {{{2, 2, 2}}}});
  const Discretization d = discretization_of(c);
  std::mt19937 generator(9);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const CellStresses stresses = centre_stresses(d.mesh, [&](const Eigen::Vector3d&) -> Voigt {
    Voigt sigma;
    for (double& component : sigma) component = uniform(generator);
    return sigma;
  });
  const VoigtColumns recovered = recover_stress_spr(d, stresses);

  // Slowly: every pair of nodes that share a cell. The polynomial of an inner node is known from the recovery alone
  // only at that node, so it is fitted here again, with axes from the patch as a whole.
  const auto patch_of = [&](int node) {
    std::vector<int> cells;
    for (int cell = 0; cell < d.mesh.cell_count(); ++cell)
      for (const int corner : d.mesh.cells[cell])
        if (corner == node) cells.push_back(cell);
    return cells;
  };
  Eigen::Matrix3Xd centres(3, d.mesh.cell_count());
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) centres.col(cell) = centre_of(d.mesh, cell);
  int checked = 0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    if (d.hanging.hangs(node) || !d.mesh.on_boundary[node]) continue;
    std::set<int> inner;
    for (const int cell : patch_of(node))
      for (const int other : d.mesh.cells[cell])
        if (!d.hanging.hangs(other) && !d.mesh.on_boundary[other]) inner.insert(other);
    if (inner.empty()) continue;
    Voigt mean = Voigt::Zero();
    for (const int other : inner) {
      std::array<int, 8> octants;
      const std::vector<int> cells = patch_of(other);
      REQUIRE(cells.size() == 8);
      for (const int cell : cells) {
        const auto& corners = d.mesh.cells[cell];
        octants[7 - (std::find(corners.begin(), corners.end(), other) - corners.begin())] = cell;
      }
      const Eigen::Matrix3d axes = fit_octants(octants, centres, stresses.centre).linear_part;
      mean += fit_patch(cells, centres, stresses.centre, axes, PatchBasis::trilinear)(d.mesh.nodes.col(node)) /
              static_cast<double>(inner.size());
    }
    CHECK((recovered.col(node) - mean).norm() < 1e-10 * (1.0 + mean.norm()));
    ++checked;
  }
  REQUIRE(checked >= 98);  // the surface nodes of 4 × 4 × 4 cells
}

TEST_CASE("centres in a plane but for the round-off of their coordinates determine no polynomial across it",
          "[recovery]") {
  // As in a lattice whose cell size is no sum of a few powers of two, where equal coordinates differ in their last bit.
  const double off = GENERATE(0.0, 0x1p-57, 0x1p-50);
  CAPTURE(off);
  Eigen::Matrix3Xd centres(3, 6);
  centres << 0.0, 0.024, 0.048, 0.0, 0.024, 0.048,  //
      0.0, 0.0, 0.0, 0.024, 0.024, 0.024,           //
      0.012, 0.012 + off, 0.012, 0.012 - off, 0.012, 0.012 + off;
  VoigtColumns values(6, 6);
  for (int cell = 0; cell < 6; ++cell) values.col(cell).setConstant(cell);
  const std::vector<int> cells = {0, 1, 2, 3, 4, 5};
  const PatchPolynomial p = fit_patch(cells, centres, values, Eigen::Matrix3d::Identity(), PatchBasis::linear);
  CHECK(p.basis == PatchBasis::mean);
  CHECK(p({0.03, 0.01, 0.024}) == Voigt::Constant(2.5));
  // Cells as flat as 1 : 10^6 do determine it.
  centres.row(2) << 0.0, 1e-8, 0.0, 0.0, 0.0, 1e-8;
  const PatchPolynomial flat = fit_patch(cells, centres, values, Eigen::Matrix3d::Identity(), PatchBasis::linear);
  CHECK(flat.basis == PatchBasis::linear);
}

TEST_CASE("a poorly determined patch gives boundary nodes its linear polynomial", "[recovery]") {
  // Eight unlike cells around the middle of the box, two of them small corners of refined ones: the eight-term fit is
  // good enough for the node itself and not for the far corner of the box, one large cell away.
  const auto [first, second, poor] = GENERATE(table<RefinementTemplate, RefinementTemplate, bool>(
      {{RefinementTemplate{{4, 4, 4}}, RefinementTemplate{{4, 4, 1}}, true},
       {RefinementTemplate{{4, 4, 1}}, RefinementTemplate{{4, 4, 4}}, true},
       {RefinementTemplate{{2, 2, 2}}, RefinementTemplate{{2, 2, 1}}, false},
       {RefinementTemplate{{2, 2, 2}}, RefinementTemplate{{2, 2, 2}}, false}}));
  CAPTURE(to_string(first), to_string(second));
  BoxMeshOptions options;
  options.cells = {2, 2, 2};
  RefinementForest forest(box_mesh(options));
  forest.refine(0, first);
  forest.refine(1, second);
  const Discretization d = discretize(forest, Material{}, {});
  std::mt19937 generator(21);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const CellStresses stresses = centre_stresses(d.mesh, [&](const Eigen::Vector3d&) -> Voigt {
    Voigt sigma;
    for (double& component : sigma) component = uniform(generator);
    return sigma;
  });
  const auto node_at = [&](const Eigen::Vector3d& X) {
    Eigen::Index node = 0;
    CHECK((d.mesh.nodes.colwise() - X).colwise().norm().minCoeff(&node) == 0.0);
    return static_cast<int>(node);
  };
  const Eigen::Vector3d middle = Eigen::Vector3d::Constant(0.5), corner = Eigen::Vector3d::Ones();
  std::array<int, 8> octants;
  Eigen::Matrix3Xd centres(3, d.mesh.cell_count());
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    centres.col(cell) = centre_of(d.mesh, cell);
    const auto& corners = d.mesh.cells[cell];
    const auto at = std::find(corners.begin(), corners.end(), node_at(middle)) - corners.begin();
    if (at < 8) octants[7 - at] = cell;
  }
  const Eigen::Matrix3d axes = fit_octants(octants, centres, stresses.centre).linear_part;
  const PatchPolynomial eight_terms = fit_patch(octants, centres, stresses.centre, axes, PatchBasis::trilinear);
  const PatchPolynomial four_terms = fit_patch(octants, centres, stresses.centre, axes, PatchBasis::linear);
  REQUIRE(eight_terms.basis == PatchBasis::trilinear);
  CAPTURE(eight_terms.condition);
  if (poor)
    REQUIRE((eight_terms.condition > 110.0 && eight_terms.condition < 1000.0));
  else
    REQUIRE((eight_terms.condition > 2.0 && eight_terms.condition < 90.0));
  const VoigtColumns recovered = recover_stress_spr(d, stresses);
  const Voigt eight = eight_terms(corner), four = four_terms(corner);
  REQUIRE((eight - four).norm() > 0.1 * four.norm());
  const Voigt& expected = poor ? four : eight;
  CHECK((recovered.col(node_at(corner)) - expected).norm() < 1e-10 * (1.0 + eight.norm()));
  // The node itself has the better fit in any case.
  CHECK((recovered.col(node_at(middle)) - eight_terms(middle)).norm() < 1e-10);
}

TEST_CASE("a polynomial is not evaluated further than one layer of cells past its patch", "[recovery]") {
  BoxMeshOptions options;
  options.cells = {5, 1, 1};
  options.size = {5.0, 1.0, 1.0};
  RefinementForest forest(box_mesh(options));
  forest.refine(0, {{2, 2, 2}});
  forest.refine(1, {{3, 1, 1}});
  const Discretization d = discretize(forest, Material{}, {});
  // The middle of the first base cell is the one inner node of the body. Its eight-term polynomial, exact on its eight
  // cells, belongs to the nodes that share one of them and to those at x = 4/3: behind one cell more, and nearer than
  // the width of the patch. Those behind have their own cells.
  const StressField field = trilinear_field(RecoveryCase{});
  const Voigt beyond = Voigt::Constant(1e3);
  const CellStresses stresses =
      centre_stresses(d.mesh, [&](const Eigen::Vector3d& X) -> Voigt { return X.x() < 1.0 ? field(X) : beyond; });
  const VoigtColumns recovered = recover_stress_spr(d, stresses);
  int beside = 0, one_more = 0, far = 0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    if (d.hanging.hangs(node)) continue;
    const Eigen::Vector3d X = d.mesh.nodes.col(node);
    CAPTURE(X.transpose());
    const Voigt expected = X.x() < 1.5 ? field(X) : beyond;
    CHECK((recovered.col(node) - expected).norm() < 1e-11 * expected.norm());
    ++(X.x() < 1.1 ? beside : X.x() < 1.5 ? one_more : far);
  }
  CHECK(beside > 8);
  CHECK(one_more == 4);
  CHECK(far == 5 * 4);
}

TEST_CASE("the estimate of a bent bar stays below the bar's energy, however far it goes on unrefined", "[recovery]") {
  // One cell across: the stress at the centres of the coarse cells knows nothing of the bending, so nearly all of their
  // energy counts as error and no more than that.
  const int length = GENERATE(8, 20, 60);
  BoxMeshOptions options;
  options.cells = {length, 1, 1};
  options.size = {static_cast<double>(length), 1.0, 1.0};
  RefinementForest forest(box_mesh(options));
  for (const int base_cell : {0, 1}) forest.refine(base_cell, {{2, 2, 2}});
  StaticProblem bar;
  bar.supports = {{"x_min", {}, {}}};
  bar.loads = {{"x_max", LoadKind::traction, {0.0, 0.0, 1.0}}};
  FactorCache factors;
  const StaticSolution solution = solve_static(forest, bar, nullptr, factors);
  REQUIRE(solution.equilibrium.converged);
  REQUIRE(solution.discretization.hanging.hanging_count() > 0);
  CAPTURE(length);
  CHECK(solution.estimate.relative > 0.3);
  CHECK(solution.estimate.relative < 1.0);
  // Beam theory: 6 length at the clamped end. The corners of that end are singular, but the cells are coarse.
  CHECK(solution.estimate.nodal_stress.cwiseAbs().maxCoeff() < 6.0 * length);
}

TEST_CASE("recovered twice over, a wave is of fourth order at the centres of cells, and a linear stress stays exact",
          "[recovery]") {
  const auto wave = [](const Eigen::Vector3d& X) -> Voigt {
    return Voigt::Constant(std::sin(5.0 * X.x() + 1.0) * std::cos(4.0 * X.y()) * std::exp(X.z()));
  };
  // Two layers from the boundary and more: each recovery reaches one cell far.
  std::array<double, 2> once{}, twice{};
  for (const int level : {0, 1}) {
    const int n = level == 0 ? 12 : 24;
    const Discretization d = discretization_of({.cells = {n, n, n}});
    const CellStresses stresses = centre_stresses(d.mesh, wave);
    const VoigtColumns of_once = recover_stress_spr(d, stresses), of_twice = recover_stress_twice(d, stresses);
    for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
      const Eigen::Vector3d X = centre_of(d.mesh, cell);
      if (X.minCoeff() < 0.249 || X.maxCoeff() > 0.751) continue;
      Voigt of_cell = Voigt::Zero(), again = Voigt::Zero();
      for (const int node : d.mesh.cells[cell]) of_cell += of_once.col(node) / 8.0, again += of_twice.col(node) / 8.0;
      once[level] = std::max(once[level], (of_cell - wave(X)).cwiseAbs().maxCoeff());
      twice[level] = std::max(twice[level], (again - wave(X)).cwiseAbs().maxCoeff());
    }
  }
  CHECK_THAT(std::log2(once[0] / once[1]), WithinAbs(2.0, 0.2));
  CHECK_THAT(std::log2(twice[0] / twice[1]), WithinAbs(4.0, 0.2));
  CHECK(twice[1] < 0.03 * once[1]);

  const auto linear = [](const Eigen::Vector3d& X) -> Voigt {
    return (Voigt() << 1.0 + X.x(), X.y() - 2.0, X.z(), X.x() + X.y(), 3.0, X.z() - X.x()).finished();
  };
  for (const CellShape shape : {CellShape::hexahedron, CellShape::tetrahedron}) {
    const Discretization d = discretization_of({.shape = shape, .perturbation = 0.1, .refinements = {{{2, 2, 2}}}});
    REQUIRE(d.hanging.hanging_count() > 0);
    const VoigtColumns recovered = recover_stress_twice(d, centre_stresses(d.mesh, linear));
    double largest = 0.0;
    for (int node = 0; node < d.mesh.node_count(); ++node)
      largest = std::max(largest, (recovered.col(node) - linear(d.mesh.nodes.col(node))).cwiseAbs().maxCoeff());
    CHECK_THAT(largest, WithinAbs(0.0, 1e-11));
  }
}
