#include "verification/support/cut_body.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "core/mesh/immersed_body.hpp"
#include "core/solve/conjugate_gradients.hpp"
#include "core/solve/multigrid.hpp"
#include "core/solve/step_solver.hpp"
#include "core/tissue_step.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/refinement_history.hpp"

using namespace finegauge;

namespace {

/// A body of a lattice of cells whose far end is cut off by a plane; `levels` of halving. Clamped at x_min, under its
/// weight.
struct CutBody {
  HalfSpace half_space;
  RefinementForest forest;
  TissueProblem problem;
  TissueMesh mesh;

  CutBody(const HalfSpace& cut, int lattice, int levels, double poisson_ratio = 0.4)
      : half_space(cut), forest(base_of(cut, lattice)) {
    for (int level = 0; level < levels; ++level)
      for (const int leaf : leaves(forest)) forest.refine(leaf, {{2, 2, 2}});
    problem.material.youngs_modulus = 1e4;
    problem.material.poisson_ratio = poisson_ratio;
    problem.material.dilatation = Dilatation::mean;
    problem.gravity = {0.0, -9.81, 0.0};
    problem.supports = {{"x_min", std::nullopt, {}}};
    Mesh leaves = forest.leaf_mesh();
    leaves.fraction = shares_in(cut, leaves);
    leaves.means = means_in(cut, leaves);
    mesh = build_tissue_mesh(forest, std::move(leaves), problem);
  }
  static BaseMesh base_of(const HalfSpace& cut, int lattice) {
    BoxMeshOptions options;
    options.cells = {lattice, lattice, lattice};
    return reached_part(cut, box_mesh(options));
  }
  BlockMatrix<double> stiffness() const {
    BlockMatrix<double> K = assemble_stiffness(mesh.d, Eigen::Matrix3Xd::Zero(3, mesh.d.mesh.node_count()));
    apply_supports(mesh.d.supports, K);
    return K;
  }
  Eigen::VectorXd weight() const {
    Eigen::VectorXd b = mesh.loads;
    project(mesh.d.supports, b);
    return b;
  }
};

/// The matrix of a step of 10 ms from rest.
BlockMatrix<double> step_matrix(const CutBody& body) {
  const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, body.mesh.d.mesh.node_count());
  TissueSystem system;
  assemble_step(body.mesh, body.problem, {zero, zero}, 0.0, 0.01, system);
  BlockMatrix<double> A = system.A;
  A.pattern = &body.mesh.d.pattern;
  return A;
}

int step_iterations(StepMethod method, const BlockMatrix<double>& A, const Eigen::VectorXd& b) {
  StepSolver solver({.method = method, .linear = {1e-9, 5000}});
  solver.set_matrix(A, false);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
  const SolveReport report = solver.solve(b, x);
  REQUIRE(report.converged);
  return report.iterations;
}

/// Preconditioned by the diagonal.
int scaled_iterations(const BlockMatrix<double>& A, const Eigen::VectorXd& b) {
  const Eigen::VectorXd diagonal = to_sparse(A).diagonal();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
  const SolveReport report = conjugate_gradients(
      A, b, [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) { z = r.cwiseQuotient(diagonal); }, {1e-9, 5000}, x);
  REQUIRE(report.converged);
  return report.iterations;
}

/// What a cut does to the systems of its body.
struct Figures {
  double scaled = 0.0, unscaled = 0.0;  ///< condition of K, with and without its diagonal taken out
  int plain = 0, plain_step = 0;        ///< iterations on K and on a step's matrix, not preconditioned
  int by_diagonal = 0, by_diagonal_step = 0;
  int kept = 0;  ///< on a step's matrix, with its factor
  double least_share = 1.0;
};

Figures figures_of(const CutBody& body) {
  const BlockMatrix<double> K = body.stiffness(), A = step_matrix(body);
  const Eigen::VectorXd b = body.weight();
  const std::vector<double>& shares = body.mesh.d.mesh.fraction;
  return {scaled_condition(K),
          condition(K),
          step_iterations(StepMethod::plain, K, b),
          step_iterations(StepMethod::plain, A, b),
          scaled_iterations(K, b),
          scaled_iterations(A, b),
          step_iterations(StepMethod::kept, A, b),
          *std::min_element(shares.begin(), shares.end())};
}

}  // namespace

TEST_CASE("how a surface cuts its cells hardly shows in condition and iterations", "[partly filled][condition]") {
  const int lattice = 4;
  const double h = 1.0 / lattice;
  const Figures whole = figures_of(CutBody({{1.0, 0.0, 0.0}, 1.0}, lattice, 0));
  REQUIRE(whole.least_share == 1.0);
  const Eigen::Vector3d normal = GENERATE(Eigen::Vector3d(1.0, 0.0, 0.0), Eigen::Vector3d(1.0, 0.3, 0.2));
  CAPTURE(normal.transpose());
  Figures least = whole, most;
  for (int k = 0; k < 16; ++k) {
    // The first one leaves a sliver of a hundred-thousandth of a cell.
    const double offset = (lattice - 2 + std::max(k / 16.0, 1e-5)) * h;
    const Figures cut = figures_of(CutBody({normal, offset}, lattice, 0));
    const auto take = [&](auto Figures::*figure) {
      least.*figure = std::min(least.*figure, cut.*figure);
      most.*figure = std::max(most.*figure, cut.*figure);
    };
    take(&Figures::scaled);
    take(&Figures::unscaled);
    take(&Figures::plain);
    take(&Figures::plain_step);
    take(&Figures::by_diagonal);
    take(&Figures::by_diagonal_step);
    take(&Figures::kept);
    take(&Figures::least_share);
  }
  CAPTURE(least.scaled, most.scaled, whole.scaled, least.unscaled, most.unscaled, whole.unscaled);
  CAPTURE(most.plain, whole.plain, most.plain_step, whole.plain_step, most.by_diagonal, whole.by_diagonal);
  CAPTURE(most.by_diagonal_step, whole.by_diagonal_step, most.kept, least.least_share);
  REQUIRE(least.least_share < 1e-4);
  // With the diagonal taken out slivers do not show: what is left is the body's length, which the cut makes shorter.
  CHECK(most.scaled <= whole.scaled);
  CHECK(least.scaled >= 0.1 * whole.scaled);
  CHECK(most.by_diagonal <= 2 * whole.by_diagonal);
  CHECK(most.by_diagonal >= whole.by_diagonal / 2);
  CHECK(most.by_diagonal_step <= 3 * whole.by_diagonal_step);
  CHECK(most.kept <= 2);
  // Without it the condition pays the least share of stiffness, 1/100, and no more however thin the sliver; iterations
  // its root, and in a step, where the whole body's mass makes the system easy and massless nodes do not, twice that.
  CHECK(most.unscaled <= whole.unscaled / least_stiffness_share);
  CHECK(most.unscaled >= 5.0 * whole.unscaled);
  CHECK(most.plain <= 10 * whole.plain);
  CHECK(most.plain >= 2 * whole.plain);
  CHECK(most.plain_step <= 20 * whole.plain_step);
}

TEST_CASE("multigrid on a cut body: shares of their own for the coarse meshes", "[partly filled][multigrid]") {
  const int lattice = 4;
  const double offset = GENERATE(0.75 + 1e-5, 0.8, 0.9, 1.0);
  const HalfSpace half_space{{0.2, 1.0, 0.3}, offset};
  CAPTURE(offset);
  const auto iterations = [](const CutBody& body, bool shares_of_their_own) {
    const Discretization& d = body.mesh.d;
    MeshHierarchy hierarchy = build_hierarchy(body.forest, d, body.problem.supports);
    REQUIRE(hierarchy.coarse.size() == 2);
    for (Discretization& coarse : hierarchy.coarse)
      if (shares_of_their_own) {
        coarse.mesh.fraction = shares_in(body.half_space, coarse.mesh);
        coarse.mesh.means = means_in(body.half_space, coarse.mesh);
      }
    const BlockMatrix<double> K = body.stiffness();
    FactorCache factors;
    Multigrid multigrid(d, K, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()), hierarchy, factors);
    REQUIRE(multigrid.usable());
    const Eigen::VectorXd b = body.weight();
    Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
    const SolveReport report = conjugate_gradients(
        K, b, [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) { multigrid.apply(r, z); }, {1e-8, 300}, x);
    REQUIRE(report.converged);
    return report.iterations;
  };
  const int whole = iterations(CutBody({{0.0, 1.0, 0.0}, 1.0}, lattice, 2, 0.3), true);
  const CutBody body(half_space, lattice, 2, 0.3);
  const std::vector<double>& shares = body.mesh.d.mesh.fraction;
  REQUIRE(std::count(shares.begin(), shares.end(), 0.0) > 50);
  REQUIRE(std::count_if(shares.begin(), shares.end(), [](double s) { return s > 0.0 && s < 0.01; }) > 5);
  const int cut = iterations(body, true), without = iterations(body, false);
  CAPTURE(whole, cut, without);
  // The cut costs a step or two; coarse meshes that think themselves full cost twice as many.
  CHECK(cut >= whole - 1);
  CHECK(cut <= whole + 4);
  CHECK(without >= whole + 6);
}

TEST_CASE("an immersed ball on springs: its mass on every mesh, and multigrid by the shares of the forest",
          "[partly filled][springs][multigrid]") {
  const TriangleSurface surface = icosphere(8, 0.05);
  ImmersedMeshOptions options;
  options.cell_size.setConstant(0.025);
  RefinementForest forest(immersed_mesh(surface, options));
  TissueProblem problem;
  problem.material.youngs_modulus = 1e4;
  problem.gravity = {0.0, 0.0, -9.81};
  SpringSupport support{"bed", {}, {}, {}};
  for (const double x : {-0.02, 0.02})
    for (const double y : {-0.02, 0.02})
      support.points.push_back({*locate_at_rest(forest.base(), {x, y, -0.03}), 100.0});
  problem.springs = {support};
  std::vector<int> iterations;
  for (int level = 0; level <= 2; ++level) {
    if (level > 0)
      for (const int leaf : leaves(forest)) forest.refine(leaf, {{2, 2, 2}});
    const TissueMesh mesh = build_tissue_mesh(forest, problem);
    const Discretization& d = mesh.d;
    REQUIRE(d.mesh.fraction.size() == d.mesh.cells.size());
    // But for what base cells that hardly have any material are left out with.
    CHECK_THAT(mesh.mass.sum(), WithinRel(problem.density * enclosed_volume(surface), 1e-6));
    CHECK(mesh.mass.minCoeff() >= 0.0);
    if (level == 0) continue;
    CHECK((mesh.mass.array() == 0.0).any());
    const MeshHierarchy hierarchy = build_hierarchy(forest, d, problem.supports);
    REQUIRE(static_cast<int>(hierarchy.coarse.size()) == level);
    for (const Discretization& coarse : hierarchy.coarse) REQUIRE_FALSE(coarse.mesh.fraction.empty());
    const BlockMatrix<double> K = assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
    FactorCache factors;
    Multigrid multigrid(d, K, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()), hierarchy, factors);
    REQUIRE(multigrid.usable());
    Eigen::VectorXd x = Eigen::VectorXd::Zero(mesh.loads.size());
    const SolveReport report = conjugate_gradients(
        K, mesh.loads, [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) { multigrid.apply(r, z); }, {1e-8, 300}, x);
    REQUIRE(report.converged);
    iterations.push_back(report.iterations);
    // The springs carry the weight.
    Eigen::Vector3d carried = Eigen::Vector3d::Zero();
    const Eigen::Matrix3Xd u = expand(d.hanging, x);
    for (const Springs::Point& point : d.springs.points)
      carried += point.stiffness * interpolate(d.mesh, u, {point.cell, point.xi});
    const Eigen::Vector3d weight = mesh.mass.sum() * problem.gravity;
    CHECK((carried - weight).norm() <= 1e-5 * weight.norm());
  }
  CAPTURE(iterations);
  CHECK(*std::max_element(iterations.begin(), iterations.end()) <= 18);  // found: 11 and 14
  CHECK(*std::min_element(iterations.begin(), iterations.end()) >= 8);
}
