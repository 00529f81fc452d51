#include "core/solve/direct_solver.hpp"

#include "core/mesh/refinement_forest.hpp"
#include "core/space/assembly.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

const SupportCondition clamped = {"x_min", {}, {}};
SupportCondition plane(const std::string& surface, const Eigen::Vector3d& normal) { return {surface, normal, {}}; }

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
  const SupportCondition x = plane("x_min", {1, 0, 0}), y = plane("y_min", {0, 1, 0}), z = plane("z_min", {0, 0, 1});
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
  CHECK(DirectSolver(Box(options, material, {clamped}).A).factored());
}
