#include "core/space/discretization.hpp"

#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

Discretization hanging_discretization(CellShape shape, const std::vector<SupportCondition>& supports = {}) {
  std::mt19937 generator(3);
  BoxMeshOptions options;
  options.cells = shape == CellShape::hexahedron ? std::array{2, 2, 2} : std::array{2, 1, 1};
  options.shape = shape;
  RefinementForest forest(scrambled(distorted_box(options, 0.1, generator), generator));
  const auto templates = all_templates(shape);
  forest.refine(0, shape == CellShape::hexahedron ? RefinementTemplate{{2, 3, 2}} : RefinementTemplate{{2, 2, 2}});
  refine_randomly(forest, {templates, 12, 4, 500}, generator);
  Discretization d = discretize(forest, Material{}, supports);
  REQUIRE(d.hanging.hanging_count() > 0);
  return d;
}

Eigen::VectorXd random_reduced(const Discretization& d, std::mt19937& generator) {
  Eigen::VectorXd x(d.dof_count());
  for (double& value : x) value = random_number(generator);
  return x;
}

}  // namespace

TEST_CASE("gather inverts expand, and the explicit T says the same", "[discretization]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Discretization d = hanging_discretization(shape);
  std::mt19937 generator(4);
  const Eigen::VectorXd x = random_reduced(d, generator);
  const Eigen::Matrix3Xd u = expand(d.hanging, x);
  CHECK(same_bits(gather(d.hanging, u), x));
  const Eigen::SparseMatrix<double> T = interpolation_matrix(d.hanging);
  CHECK(T.rows() == 3 * d.mesh.node_count());
  CHECK(T.cols() == d.dof_count());
  CHECK((T * x - u.reshaped()).cwiseAbs().maxCoeff() <= 1e-13);
}

TEST_CASE("forces are reduced by the adjoint of expand", "[discretization]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Discretization d = hanging_discretization(shape);
  std::mt19937 generator(5);
  const Eigen::VectorXd x = random_reduced(d, generator);
  Eigen::Matrix3Xd f(3, d.mesh.node_count());
  for (double& value : f.reshaped()) value = random_number(generator);
  const double work = f.cwiseProduct(expand(d.hanging, x)).sum();
  CHECK_THAT(reduce_forces(d.hanging, f).dot(x), WithinAbs(work, 1e-11));
  CHECK(std::abs(work) > 1e-3);
  // So a reduced load has the same resultant: x = a translation.
  Eigen::Vector3d resultant = Eigen::Vector3d::Zero();
  const Eigen::VectorXd b = reduce_forces(d.hanging, f);
  for (int i = 0; i < d.hanging.reduced_count(); ++i) resultant += b.segment<3>(3 * i);
  CHECK((resultant - f.rowwise().sum()).norm() <= 1e-11);
}

TEST_CASE("imposed displacements are what is prescribed, and the rest stays", "[discretization]") {
  const Eigen::Vector3d normal = Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0;
  const auto prescribed = [](const Eigen::Vector3d& X) { return Eigen::Vector3d(X.y(), 0.1, X.z() - X.y()); };
  const Discretization d =
      hanging_discretization(CellShape::hexahedron, {{"x_min", {}, prescribed}, {"x_max", normal, prescribed}});
  std::mt19937 generator(6);
  const Eigen::VectorXd x = random_reduced(d, generator);
  Eigen::VectorXd imposed = x, projected = x;
  impose(d.supports, imposed);
  project(d.supports, projected);
  const Eigen::Matrix3Xd u = expand(d.hanging, imposed), before = expand(d.hanging, x);
  int clamped = 0, rolling = 0, hanging_clamped = 0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const Eigen::Vector3d X = d.mesh.nodes.col(node);
    if (X.x() < 1e-12) {
      ++clamped;
      hanging_clamped += d.hanging.hangs(node);
      CHECK((u.col(node) - prescribed(X)).norm() <= 1e-12);  // linear, so hanging nodes have it too
    } else if (X.x() > 1.0 - 1e-12) {
      ++rolling;
      CHECK_THAT(normal.dot(u.col(node)), WithinAbs(normal.dot(prescribed(X)), 1e-12));
    }
  }
  CHECK(clamped > 0);
  CHECK(hanging_clamped > 0);
  CHECK(rolling > 0);
  Eigen::VectorXd free_part = imposed;
  project(d.supports, free_part);
  CHECK((free_part - projected).norm() <= 1e-13);
  CHECK(static_cast<int>(d.supports.reduced.size()) < d.hanging.reduced_count());
}

TEST_CASE("the pattern holds exactly the pairs of reduced nodes that meet in a cell", "[discretization]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Discretization d = hanging_discretization(shape);
  const int n = d.hanging.reduced_count();
  std::vector<std::vector<char>> meet(n, std::vector<char>(n, 0));
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    std::vector<int> masters;
    for (int c = 0; c < corner_count(shape); ++c) {
      const int node = d.mesh.cells[cell][c];
      for (int k = d.hanging.row_start[node]; k < d.hanging.row_start[node + 1]; ++k)
        masters.push_back(d.hanging.master[k]);
    }
    for (const int a : masters)
      for (const int b : masters) meet[a][b] = 1;
  }
  REQUIRE(d.pattern.size() == n);
  int expected = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) expected += meet[i][j];
  CHECK(d.pattern.block_count() == expected);
  for (int i = 0; i < n; ++i) {
    CHECK(d.pattern.column[d.pattern.diagonal[i]] == i);
    for (int p = d.pattern.row_start[i]; p < d.pattern.row_start[i + 1]; ++p) {
      CHECK(meet[i][d.pattern.column[p]] == 1);
      if (p > d.pattern.row_start[i]) CHECK(d.pattern.column[p] > d.pattern.column[p - 1]);
    }
  }
  CHECK(d.scatter.regular.size() + d.scatter.hanging.size() == static_cast<std::size_t>(d.mesh.cell_count()));
  CHECK_FALSE(d.scatter.hanging.empty());
}
