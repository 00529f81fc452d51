#include "core/solve/multigrid.hpp"

#include <Eigen/LU>

#include "core/equilibrium.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

const std::vector<SupportCondition> clamped_end = {{"x_min", {}, {}}};
const std::vector<SurfaceLoad> sideways = {{"x_max", LoadKind::traction, {0.5, 1.0, -2.0}}};

Material material_of(Kinematics kinematics = Kinematics::linear) {
  Material material;
  material.dilatation = Dilatation::mean;
  material.kinematics = kinematics;
  return material;
}

struct System {
  Discretization d;
  MeshHierarchy hierarchy;
  Eigen::Matrix3Xd u;
  BlockMatrix<double> A;
  Eigen::VectorXd b;

  System(const RefinementForest& forest, const Material& material, const std::vector<SupportCondition>& supports,
         const HierarchyOptions& options = {})
      : d(discretize(forest, material, supports)), hierarchy(build_hierarchy(forest, d, supports, options)) {
    u = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
    assemble();
    b = reduce_forces(d.hanging, nodal_loads(forest.base(), d.mesh, sideways));
    project(d.supports, b);
  }
  void assemble() {
    A = assemble_stiffness(d, u);
    apply_supports(d.supports, A);
  }
  System(const System&) = delete;
  System& operator=(const System&) = delete;
};

int iterations_of(System& system, double tolerance = 1e-8) {
  FactorCache factors;
  Multigrid multigrid(system.d, system.A, system.u, system.hierarchy, factors);
  REQUIRE(multigrid.usable());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(system.b.size());
  const SolveReport report = conjugate_gradients(
      system.A, system.b, [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) { multigrid.apply(r, z); },
      {tolerance, 300}, x);
  REQUIRE(report.converged);
  return report.iterations;
}

RefinementForest refined_box(CellShape shape, int cells, int levels) {
  BoxMeshOptions options;
  options.cells = {cells, cells, cells};
  options.shape = shape;
  RefinementForest forest(box_mesh(options));
  for (int level = 0; level < levels; ++level)
    for (const int leaf : leaves(forest)) forest.refine(leaf, {{2, 2, 2}});
  return forest;
}

/// Refined towards an edge of the box, `levels` times, by one template: hanging nodes on every level.
RefinementForest graded_box(CellShape shape, RefinementTemplate refinement, int levels) {
  RefinementForest forest = refined_box(shape, 2, 1);
  for (int level = 0; level < levels; ++level) {
    const Mesh mesh = forest.leaf_mesh();
    for (int cell = 0; cell < mesh.cell_count(); ++cell) {
      bool touches = false;
      for (int c = 0; c < corner_count(shape); ++c) {
        const auto X = mesh.nodes.col(mesh.cells[cell][c]);
        touches = touches || (X.x() < 1e-9 && X.z() > 1.0 - 1e-9);
      }
      if (touches) forest.refine(mesh.forest_cell[cell], refinement);
    }
  }
  return forest;
}

}  // namespace

TEST_CASE("the multigrid cycle is symmetric and positive", "[multigrid]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  std::mt19937 generator(3);
  BoxMeshOptions options;
  options.cells = shape == CellShape::hexahedron ? std::array{3, 2, 2} : std::array{2, 1, 1};
  options.shape = shape;
  RefinementForest forest(scrambled(distorted_box(options, 0.1, generator), generator));
  const auto templates = all_templates(shape);
  refine_randomly(forest, {templates, 20, 4, 1000}, generator);
  const std::vector<SupportCondition> supports = {{"x_min", {}, {}}, {"z_min", Eigen::Vector3d(0.0, 0.0, 1.0), {}}};
  System system(forest, material_of(kinematics), supports, {10, 0.9});
  REQUIRE(system.hierarchy.coarse.size() >= 2);
  REQUIRE(system.d.hanging.hanging_count() > 0);
  if (kinematics == Kinematics::corotational) {
    Eigen::VectorXd reduced(system.d.dof_count());
    for (double& value : reduced) value = 0.02 * random_number(generator);
    system.u = turn_about_random_axis(1.0, generator) * system.d.mesh.nodes + expand(system.d.hanging, reduced) -
               system.d.mesh.nodes;
    system.assemble();
  }
  FactorCache factors;
  Multigrid multigrid(system.d, system.A, system.u, system.hierarchy, factors);
  REQUIRE(multigrid.usable());
  for (int trial = 0; trial < 10; ++trial) {
    Eigen::VectorXd r(system.b.size()), s(system.b.size()), Mr, Ms;
    for (double& value : r) value = random_number(generator);
    for (double& value : s) value = random_number(generator);
    project(system.d.supports, r);
    project(system.d.supports, s);
    multigrid.apply(r, Mr);
    multigrid.apply(s, Ms);
    // Single precision, 6e-8, times the few hundred operations that a value sees.
    CHECK_THAT(s.dot(Mr) - r.dot(Ms), WithinAbs(0.0, 1e-5 * std::sqrt(r.dot(Mr) * s.dot(Ms))));
    CHECK(r.dot(Mr) > 0.0);
    Eigen::VectorXd held = Mr, free_part = Mr;
    project(system.d.supports, free_part);
    CHECK((held - free_part).norm() <= 1e-6 * Mr.norm());  // nothing moves in held directions
    Eigen::VectorXd scaled;
    multigrid.apply(1e-30 * r, scaled);
    CHECK((1e30 * scaled - Mr).norm() <= 1e-5 * Mr.norm());
  }
}

TEST_CASE("a cycle on two meshes is sweep, restriction to what is free, solve, correction, sweep", "[multigrid]") {
  // The roller's normal is no axis: what it holds mixes all components. The dense formula in double precision.
  std::mt19937 generator(11);
  BoxMeshOptions options;
  options.cells = {2, 2, 2};
  BaseMesh base = box_mesh(options);
  const Eigen::Matrix3d Q = turn_about_random_axis(0.8, generator);
  base.nodes = Q * base.nodes;
  RefinementForest forest(base);
  for (const int leaf : leaves(forest)) forest.refine(leaf, {{2, 2, 2}});
  forest.refine(forest.cell(0).first_child, {{2, 2, 1}});
  const std::vector<SupportCondition> supports = {{"x_min", {}, {}}, {"z_min", Eigen::Vector3d(Q.col(2)), {}}};
  System system(forest, material_of(), supports, {1, 0.2});
  REQUIRE(system.d.hanging.hanging_count() > 0);
  REQUIRE(system.hierarchy.coarse.size() == 1);
  const Discretization& coarse = system.hierarchy.coarse[0];
  BlockMatrix<double> coarse_matrix = assemble_stiffness(coarse, Eigen::Matrix3Xd::Zero(3, coarse.mesh.node_count()));
  apply_supports(coarse.supports, coarse_matrix);
  const Eigen::MatrixXd A(to_sparse(system.A)), Ac(to_sparse(coarse_matrix));
  const Prolongation& rows = system.hierarchy.prolongations[0];
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(A.rows(), Ac.rows());
  for (int i = 0; i < system.d.hanging.reduced_count(); ++i)
    for (int k = rows.row_start[i]; k < rows.row_start[i + 1]; ++k)
      P.block<3, 3>(3 * i, 3 * rows.column[k]) += rows.weight[k] * Eigen::Matrix3d::Identity();
  // Block Gauss-Seidel: the lower triangle of 3 × 3 blocks, diagonal blocks whole.
  Eigen::MatrixXd lower = A;
  for (Eigen::Index i = 0; i < A.rows() / 3; ++i) lower.middleRows<3>(3 * i).rightCols(A.cols() - 3 * i - 3).setZero();
  FactorCache factors;
  Multigrid multigrid(system.d, system.A, system.u, system.hierarchy, factors);
  REQUIRE(multigrid.usable());
  for (int trial = 0; trial < 5; ++trial) {
    Eigen::VectorXd r(A.rows()), z;
    for (double& value : r) value = random_number(generator);
    project(system.d.supports, r);
    Eigen::VectorXd x = lower.partialPivLu().solve(r);
    Eigen::VectorXd restricted = P.transpose() * (r - A * x), free_part = restricted;
    project(coarse.supports, free_part);
    // Otherwise nothing is there to leave out.
    CHECK((restricted - free_part).norm() > 0.1 * free_part.norm());
    x += P * Ac.partialPivLu().solve(free_part);
    x += lower.transpose().partialPivLu().solve(r - A * x);
    multigrid.apply(r, z);
    CHECK((z - x).norm() <= 1e-5 * x.norm());  // single precision, 6e-8, times the smoothers' and solve's conditions
  }
}

TEST_CASE("multigrid iterations hardly grow with uniform refinement", "[multigrid]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  std::vector<int> iterations;
  for (int levels = 1; levels <= 3; ++levels) {
    const RefinementForest forest = refined_box(shape, shape == CellShape::hexahedron ? 4 : 2, levels);
    System system(forest, material_of(), clamped_end, {50, 0.6});
    REQUIRE(static_cast<int>(system.hierarchy.coarse.size()) == levels);
    iterations.push_back(iterations_of(system));
  }
  CAPTURE(iterations);
  // 13, 13, 12 for hexahedra; 14, 17, 18 for the six tetrahedra of a lattice cell, whose angles are worse.
  CHECK(iterations[0] >= 8);
  CHECK(iterations[2] <= iterations[0] + (shape == CellShape::hexahedron ? 2 : 6));
  CHECK(iterations[2] <= 22);
}

TEST_CASE("multigrid iterations hardly grow with grading across hanging nodes", "[multigrid][hanging]") {
  const auto [shape, refinement] = GENERATE(table<CellShape, RefinementTemplate>({
      {CellShape::hexahedron, RefinementTemplate{{2, 2, 2}}},
      {CellShape::hexahedron, RefinementTemplate{{3, 3, 3}}},
      {CellShape::hexahedron, RefinementTemplate{{2, 1, 2}}},
      {CellShape::tetrahedron, RefinementTemplate{{2, 2, 2}}},
  }));
  std::vector<int> iterations;
  for (int levels = 1; levels <= 4; ++levels) {
    if (levels == 4 && refinement == RefinementTemplate{{3, 3, 3}}) break;
    const RefinementForest forest = graded_box(shape, refinement, levels);
    System system(forest, material_of(), clamped_end, {50, 0.9});
    REQUIRE(system.d.hanging.hanging_count() > 0);
    REQUIRE_FALSE(system.hierarchy.coarse.empty());
    iterations.push_back(iterations_of(system));
  }
  CAPTURE(static_cast<int>(shape), to_string(refinement), iterations);
  CHECK(iterations.front() >= 8);  // 13 or 14 on every mesh
  CHECK(iterations.back() <= iterations.front() + 3);
  CHECK(iterations.back() <= 20);
}

TEST_CASE("multigrid and direct solutions agree", "[multigrid]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const RefinementForest forest = graded_box(shape, {{2, 2, 2}}, 3);
  System system(forest, material_of(), clamped_end, {50, 0.9});
  FactorCache factors;
  Multigrid multigrid(system.d, system.A, system.u, system.hierarchy, factors);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(system.b.size());
  const SolveReport report = conjugate_gradients(
      system.A, system.b, [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) { multigrid.apply(r, z); }, {1e-12, 300},
      x);
  CHECK(report.converged);
  const DirectSolver direct(system.A);
  REQUIRE(direct.factored());
  const Eigen::VectorXd exact = direct.solve(system.b);
  CHECK((x - exact).norm() <= 1e-9 * exact.norm());
}

TEST_CASE("levels are nested meshes with few nodes at the bottom", "[multigrid]") {
  const RefinementForest forest = refined_box(CellShape::hexahedron, 2, 3);
  const Discretization d = discretize(forest, material_of(), clamped_end);
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, clamped_end, {30, 0.6});
  REQUIRE(hierarchy.coarse.size() == 3);
  CHECK(hierarchy.coarse[0].mesh.cell_count() == 512);
  CHECK(hierarchy.coarse[1].mesh.cell_count() == 64);
  CHECK(hierarchy.coarse[2].mesh.cell_count() == 8);
  // Each prolongation keeps linear fields.
  const Discretization* fine = &d;
  for (std::size_t level = 0; level < hierarchy.coarse.size(); ++level) {
    const auto& P = hierarchy.prolongations[level];
    const Discretization& coarse = hierarchy.coarse[level];
    double error = 0.0;
    for (int i = 0; i < fine->hanging.reduced_count(); ++i) {
      Eigen::Vector3d x = -fine->mesh.nodes.col(fine->hanging.node_of[i]);
      for (int k = P.row_start[i]; k < P.row_start[i + 1]; ++k)
        x += P.weight[k] * coarse.mesh.nodes.col(coarse.hanging.node_of[P.column[k]]);
      error = std::max(error, x.norm());
    }
    CHECK_THAT(error, WithinAbs(0.0, 1e-6));  // single precision
    fine = &coarse;
  }
  CHECK(build_hierarchy(forest, d, clamped_end, {100000, 0.6}).coarse.empty());
}

TEST_CASE("a body that nothing holds is not solved", "[multigrid]") {
  const RefinementForest forest = refined_box(CellShape::hexahedron, 2, 2);
  const auto method = GENERATE(LinearMethod::direct, LinearMethod::multigrid);
  const Discretization d = discretize(forest, material_of(), {});
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, {}, {30, 0.6});
  const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, sideways);
  EquilibriumOptions options;
  options.method = method;
  CHECK_FALSE(
      solve_equilibrium(d, hierarchy, loads, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()), options).converged);
}
