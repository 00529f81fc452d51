#include "core/solve/direct_solver.hpp"

#include <cmath>

#include "core/mesh/refinement_forest.hpp"
#include "core/space/assembly.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

const SupportCondition clamped_side = {"x_min", {}, {}};
SupportCondition sliding_plane(const std::string& surface, const Eigen::Vector3d& normal) {
  return {surface, normal, {}};
}

/// The stiffness of a box at rest, with its supports.
struct Box {
  Discretization discretization;
  BlockMatrix<double> A;

  Box(const BoxMeshOptions& options, const Material& material, const std::vector<SupportCondition>& supports)
      : discretization(discretize(RefinementForest(box_mesh(options)), material, supports)) {
    A = assemble_stiffness(discretization, Eigen::Matrix3Xd::Zero(3, discretization.mesh.node_count()));
    apply_supports(discretization.supports, A);
  }
  Box(const Box&) = delete;
  Box& operator=(const Box&) = delete;
};

BoxMeshOptions box_of(std::array<int, 3> cells, const Eigen::Vector3d& size = Eigen::Vector3d::Ones()) {
  BoxMeshOptions options;
  options.cells = cells;
  options.size = size;
  return options;
}

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 generator(seed);
  Eigen::MatrixXd B(rows, columns);
  for (double& value : B.reshaped()) value = random_number(generator);
  return B;
}
Eigen::VectorXd random_column(Eigen::Index rows, unsigned seed) { return random_matrix(rows, 1, seed); }

/// Cells of each factor's kind: CHOLMOD works by columns below 2000 unknowns, by supernodes from there on.
constexpr std::array<int, 3> simplicial = {5, 4, 3}, supernodal = {10, 9, 8};

}  // namespace

TEST_CASE("one negative pivot among positive ones is refused", "[direct]") {
  BlockPattern pattern;
  pattern.row_start = {0, 1, 2, 3};
  pattern.column = pattern.diagonal = {0, 1, 2};
  BlockMatrix<double> A;
  A.reset(pattern);
  const double middle = GENERATE(1.0, 1e-9, 0.0, -1e-9, -1.0);
  CAPTURE(middle);
  const double values[] = {1.0, middle, 2.0};
  for (int p = 0; p < 3; ++p) A.block(p) = values[p] * Eigen::Matrix3d::Identity();
  CHECK(DirectSolver(A).factored() == (middle > 0.0));
  A.block(1) = Eigen::Vector3d(1.0, middle, 2.0).asDiagonal();
  CHECK(DirectSolver(A).factored() == (middle > 0.0));
}

TEST_CASE("the stiffness of a body that is not held is refused", "[direct]") {
  BoxMeshOptions options;
  const int n = GENERATE(1, 2, 4, 8, 12);
  options.cells = {n, n, n};
  options.shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  Material material;
  material.dilatation = Dilatation::mean;
  material.poisson_ratio = GENERATE(0.3, 0.4999);
  CAPTURE(n, int(options.shape), material.poisson_ratio);
  const SupportCondition x = sliding_plane("x_min", {1, 0, 0}), y = sliding_plane("y_min", {0, 1, 0}),
                         z = sliding_plane("z_min", {0, 0, 1});
  CHECK_FALSE(DirectSolver(Box(options, material, {}).A).factored());
  CHECK_FALSE(DirectSolver(Box(options, material, {x}).A).factored());
  CHECK_FALSE(DirectSolver(Box(options, material, {x, y}).A).factored());
  CHECK(DirectSolver(Box(options, material, {x, y, z}).A).factored());
}

TEST_CASE("held bodies of slender cells and almost incompressible ones are factored", "[direct]") {
  struct Case {
    std::array<int, 3> cells;
    Eigen::Vector3d size;
  };
  const auto [cells, size] = GENERATE(values<Case>({{{2, 1, 1}, {1000, 1, 1}},     // a bar of two cells 1:500
                                                    {{300, 1, 1}, {300, 1, 1}},    // a slender bar of cubes
                                                    {{8, 8, 8}, {1, 1, 1e-3}},     // cells 1:1000 in a plate
                                                    {{6, 6, 1}, {600, 600, 0.1}},  // one layer of cells 1:1000
                                                    {{6, 6, 6}, {1, 1, 1}}}));
  BoxMeshOptions options;
  options.cells = cells;
  options.size = size;
  Material material;
  material.dilatation = Dilatation::mean;
  material.poisson_ratio = GENERATE(0.3, 0.4999);
  CAPTURE(cells, material.poisson_ratio);
  CHECK(DirectSolver(Box(options, material, {clamped_side}).A).factored());
}

TEST_CASE("bars and plates of cells 1:1000 are factored at nu = 0.49999, and refused when they are not held",
          "[direct]") {
  const auto [shape, cells, size] = GENERATE(
      table<CellShape, std::array<int, 3>, Eigen::Vector3d>({{CellShape::hexahedron, {30, 1, 1}, {30000, 1, 1}},
                                                             {CellShape::hexahedron, {8, 8, 8}, {1, 1, 1e-3}},
                                                             {CellShape::hexahedron, {6, 6, 1}, {600, 600, 0.1}},
                                                             {CellShape::tetrahedron, {8, 8, 8}, {1, 1, 1e-3}},
                                                             {CellShape::tetrahedron, {6, 6, 1}, {600, 600, 0.1}}}));
  BoxMeshOptions options = box_of(cells, size);
  options.shape = shape;
  Material material;
  material.dilatation = Dilatation::mean;
  material.poisson_ratio = 0.49999;
  CAPTURE(cells, int(options.shape));
  const DirectSolver held(Box(options, material, {clamped_side}).A);
  CHECK(held.factored());
  CHECK(held.smallest_pivot() < 1e-7);  // otherwise the case is an easy one
  const SupportCondition x = sliding_plane("x_min", {1, 0, 0}), y = sliding_plane("y_min", {0, 1, 0});
  CHECK_FALSE(DirectSolver(Box(options, material, {}).A).factored());
  CHECK_FALSE(DirectSolver(Box(options, material, {x, y}).A).factored());
}

TEST_CASE("the scale of single rows does not decide whether a matrix is factored", "[direct]") {
  // 1 m of rock beside a micrometre of foam: pivots 18 decades apart, none of them round-off.
  BlockPattern pattern;
  pattern.row_start = {0, 1, 2};
  pattern.column = pattern.diagonal = {0, 1};
  BlockMatrix<double> A;
  A.reset(pattern);
  A.block(0) = Eigen::Vector3d(1e9, 2e9, 1.0).asDiagonal();
  A.block(1) = Eigen::Vector3d(1e-9, 1.0, 3e-9).asDiagonal();
  const DirectSolver solver(A);
  CHECK(solver.factored());
  CHECK_THAT(solver.smallest_pivot(), WithinAbs(1.0, 1e-15));         // a root, squared
  A.block(1) << 1.0, 1.0, 0.0, 1.0, 1.0 + 2e-16, 0.0, 0.0, 0.0, 1.0;  // one ulp above singular
  CHECK_FALSE(DirectSolver(A).factored());
}

TEST_CASE("units that are powers of two apart give the same bits", "[direct]") {
  const Box box(box_of(GENERATE(simplicial, supernodal)), Material{}, {clamped_side});
  const Eigen::VectorXd b = random_column(box.discretization.dof_count(), 3);
  const DirectSolver solver(box.A);
  REQUIRE(solver.factored());
  const Eigen::VectorXd x = solver.solve(b);
  int differing = 0;
  for (int k = -31; k <= 33; k += 4) {  // odd: the root of the scale is not a power of two
    BlockMatrix<double> scaled = box.A;
    for (double& value : scaled.values) value = std::ldexp(value, k);
    const DirectSolver other(scaled);
    REQUIRE(other.factored());
    CHECK(other.smallest_pivot() == solver.smallest_pivot());
    differing += Eigen::VectorXd(std::ldexp(1.0, k) * other.solve(b)) != x;
    differing += Eigen::VectorXd(other.solve(Eigen::VectorXd(std::ldexp(1.0, k + 3) * b)) * 0.125) != x;
  }
  CHECK(differing == 0);
  BlockMatrix<double> scaled = box.A;
  for (double& value : scaled.values) value = std::ldexp(value, -30);
  CHECK(Eigen::VectorXd(std::ldexp(1.0, -30) * DirectSolver(scaled).solve(b)) == x);
  // By three, on the other hand, rounds differently: the comparison can fail.
  for (double& value : scaled.values) value *= 3.0;
  CHECK(Eigen::VectorXd(3.0 * std::ldexp(1.0, -30) * DirectSolver(scaled).solve(b)) != x);
}

TEST_CASE("factoring again on the same pattern is factoring afresh, to the bit", "[direct]") {
  const auto cells = GENERATE(simplicial, supernodal);
  Material stiff, soft;
  stiff.youngs_modulus = 1e9;
  soft.youngs_modulus = 3.0;
  soft.poisson_ratio = 0.4;
  const Box first(box_of(cells), stiff, {clamped_side}), second(box_of(cells), soft, {clamped_side}),
      loose(box_of(cells), soft, {});
  const Eigen::VectorXd b = random_column(first.discretization.dof_count(), 4);
  DirectSolver solver(first.A);
  REQUIRE(solver.factored());
  CHECK(solver.is_factor_of(first.A));
  const Eigen::VectorXd x = solver.solve(b);
  REQUIRE(solver.refactor(second.A));
  CHECK(solver.is_factor_of(second.A));
  CHECK_FALSE(solver.is_factor_of(first.A));
  CHECK(solver.solve(b) == DirectSolver(second.A).solve(b));
  CHECK(solver.solve(b) != x);
  // A body that is not held in between is refused and leaves no trace.
  CHECK_FALSE(solver.refactor(loose.A));
  CHECK_FALSE(solver.factored());
  REQUIRE(solver.refactor(first.A));
  CHECK(solver.solve(b) == x);
}

TEST_CASE("many right sides are solved at once as one by one", "[direct]") {
  const Box box(box_of(GENERATE(simplicial, supernodal)), Material{}, {clamped_side});
  const DirectSolver solver(box.A);
  REQUIRE(solver.factored());
  const Eigen::MatrixXd B = random_matrix(box.discretization.dof_count(), 7, 5);
  const Eigen::MatrixXd X = solver.solve_columns(B);
  REQUIRE(X.cols() == 7);
  for (int k = 0; k < 7; ++k) {
    const Eigen::VectorXd b = B.col(k), x = solver.solve(b);
    // Other kernels, the same factor: round-off times the condition, some 1e3.
    CHECK((X.col(k) - x).norm() <= 1e-12 * x.norm());
    CHECK(x.norm() > 0.0);
  }
  CHECK(solver.solve_columns(Eigen::MatrixXd(B.rows(), 0)).cols() == 0);
}

TEST_CASE("a direct solve is converged at the residual that was asked for and at no other", "[direct]") {
  // A slender bar: round-off allows ε ‖A‖ ‖x‖ / ‖b‖, here some 1e-7.
  const Box box(box_of({300, 1, 1}, {300, 1, 1}), Material{}, {clamped_side});
  const DirectSolver solver(box.A);
  REQUIRE(solver.factored());
  Eigen::VectorXd b = Eigen::VectorXd::Zero(box.discretization.dof_count()), x, Ax;
  const auto& mesh = box.discretization.mesh;
  for (int node = 0; node < mesh.node_count(); ++node)
    if (mesh.nodes(0, node) > 299.5) b[3 * node + 2] = 1.0;
  const SolveReport easy = solve_refined(solver, box.A, b, 1e-5, x);
  CHECK(easy.converged);
  CHECK(easy.iterations == 1);
  multiply(box.A, x, Ax);
  CHECK(easy.relative_residual == (b - Ax).norm() / b.norm());
  const SolveReport impossible = solve_refined(solver, box.A, b, 1e-16, x);
  CHECK_FALSE(impossible.converged);
  CHECK(impossible.iterations <= 4);
  CHECK(impossible.iterations >= 2);
  CHECK(impossible.relative_residual <= easy.relative_residual);
  CHECK(impossible.relative_residual > 1e-16);
  CHECK(impossible.relative_residual < 1e-6);
  multiply(box.A, x, Ax);
  CHECK(impossible.relative_residual == (b - Ax).norm() / b.norm());  // of the best, which is what is returned
  // What can be had is converged, half of it is not.
  const double floor = impossible.relative_residual;
  CHECK(solve_refined(solver, box.A, b, floor, x).converged);
  CHECK_FALSE(solve_refined(solver, box.A, b, 0.5 * floor, x).converged);
  CHECK(solve_refined(solver, box.A, Eigen::VectorXd::Zero(b.size()), 1e-16, x).converged);
  CHECK(x.isZero(0.0));
}

TEST_CASE("iterative refinement makes up for a factor of a slightly different matrix", "[direct]") {
  Material material;
  const Box box(box_of({4, 4, 4}), material, {clamped_side});
  material.youngs_modulus *= 1.0 + 1e-4;
  material.poisson_ratio += 1e-5;
  const Box other(box_of({4, 4, 4}), material, {clamped_side});
  const DirectSolver solver(other.A);
  const Eigen::VectorXd b = random_column(box.discretization.dof_count(), 6);
  Eigen::VectorXd x;
  // Each step gains the four digits in which the matrices agree.
  const SolveReport one = solve_refined(solver, box.A, b, 1e-3, x), three = solve_refined(solver, box.A, b, 1e-10, x);
  CHECK(one.converged);
  CHECK(one.iterations == 1);
  CHECK(one.relative_residual > 1e-6);
  CHECK(three.converged);
  CHECK(three.iterations == 3);
  CHECK_FALSE(solve_refined(solver, box.A, b, 1e-30, x).converged);
}
