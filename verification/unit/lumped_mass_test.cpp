#include "core/space/lumped_mass.hpp"

#include <Eigen/SparseCore>
#include <algorithm>

#include "core/space/loads.hpp"
#include "core/space/transfer.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/tissue_samples.hpp"

using namespace finegauge;

namespace {

/// m_nodal = ∫ ρ N of all nodes by 3×3×3 Gauss points, as the load of a body force: another rule, another code.
Eigen::VectorXd nodal_mass(const RefinementForest& forest, const Mesh& mesh, double density) {
  const auto unit = [density](const Eigen::Vector3d&) { return Eigen::Vector3d(density, 0.0, 0.0); };
  return nodal_loads(forest.base(), mesh, {}, unit, 3).row(0).transpose();
}

/// Tᵀ m_nodal, with T as an explicit matrix.
Eigen::VectorXd reduced_mass(const RefinementForest& forest, const Discretization& d, double density) {
  Eigen::Matrix3Xd at_x = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  at_x.row(0) = nodal_mass(forest, d.mesh, density).transpose();
  const Eigen::VectorXd reduced = interpolation_matrix(d.hanging).transpose() * at_x.reshaped();
  return reduced.reshaped(3, d.hanging.reduced_count()).row(0).transpose();
}

double smallest_weight(const HangingNodes& hanging) {
  return *std::min_element(hanging.weight.begin(), hanging.weight.end());
}

RandomBody body_of_kind(int kind) {
  RandomBody body;
  body.refinements = 10;
  body.max_depth = 3;
  if (kind == 0) body.templates = {{{2, 2, 2}}};
  if (kind == 1) body.templates = {{{3, 3, 3}}};
  if (kind == 3) body.templates = all_templates();
  if (kind == 4) body.shape = CellShape::tetrahedron;
  return body;
}

}  // namespace

TEST_CASE("the lumped mass of a mesh with hanging nodes is positive, complete and Tᵀ of the nodal one",
          "[lumped_mass][hanging]") {
  // Halves, thirds, both with 2x3x3, all 63 templates, tetrahedra.
  const int kind = GENERATE(0, 1, 2, 3, 4);
  const unsigned seed = GENERATE(1u, 2u, 3u, 4u, 5u, 6u);
  CAPTURE(kind, seed);
  std::mt19937 generator(seed);
  const RefinementForest forest = random_body(body_of_kind(kind), generator);
  const Discretization d = discretize(forest, {}, {});
  REQUIRE(d.hanging.hanging_count() > 0);
  REQUIRE(smallest_weight(d.hanging) >= 0.0);
  REQUIRE(cells_with_scaled_mass(d).empty());
  const double density = 1060.0;
  const Eigen::VectorXd mass = lumped_mass(d, density);
  REQUIRE(mass.size() == d.hanging.reduced_count());
  CHECK(mass.minCoeff() > 0.0);
  // The box keeps its planes when its cells are distorted: one cubic metre. Round-off of some 1e4 terms of one sign.
  CHECK_THAT(mass.sum(), WithinRel(density, 1e-12));
  const Eigen::VectorXd expected = reduced_mass(forest, d, density);
  CHECK(((mass - expected).array().abs() <= 1e-12 * expected.array()).all());
}

TEST_CASE("the mass of a coarser mesh is the adjoint interpolation of that of a finer one", "[lumped_mass][hanging]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const unsigned seed = GENERATE(1u, 2u, 3u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  RandomBody body;
  body.shape = shape;
  const RefinementForest forest = random_body(body, generator);
  const Discretization fine = discretize(forest, {}, {}), coarse = discretize(forest, {}, {}, 1);
  REQUIRE(coarse.mesh.cell_count() < fine.mesh.cell_count());
  REQUIRE(fine.hanging.hanging_count() > 0);
  const Eigen::VectorXd m_fine = lumped_mass(fine, 1.0), m_coarse = lumped_mass(coarse, 1.0);
  // P by its columns: the coarse functions, three at a time, as fields of the fine mesh.
  double largest = 0.0;
  for (int i = 0; i < coarse.hanging.reduced_count(); ++i) {
    Eigen::VectorXd one = Eigen::VectorXd::Zero(coarse.dof_count());
    one[3 * i] = 1.0;
    const Eigen::VectorXd column = gather(fine.hanging, transfer(coarse.mesh, expand(coarse.hanging, one), fine.mesh));
    double adjoint = 0.0;
    for (int f = 0; f < fine.hanging.reduced_count(); ++f) adjoint += column[3 * f] * m_fine[f];
    largest = std::max(largest, std::abs(adjoint - m_coarse[i]) / m_coarse[i]);
  }
  CHECK_THAT(largest, WithinAbs(0.0, 1e-12));
}

TEST_CASE("where weights of T are negative, row sums may be too, and the scaled diagonal keeps mass and sign",
          "[lumped_mass][hanging]") {
  // Random forests have such weights once in some 30,000, and too small ones to turn a row sum; here a hanging node is
  // told to extrapolate from two of its masters, as the interpolation of a point outside of them would.
  const unsigned seed = GENERATE(2u, 3u, 6u);  // whose forests have such cells, full and cut
  CAPTURE(seed);
  std::mt19937 generator(seed);
  BoxMeshOptions options;
  options.cells = {2, 2, 1};
  RefinementForest forest(scrambled(distorted_box(options, 0.1, generator), generator));
  refine_randomly(forest, {all_templates(), 12, 3, 300}, generator);
  Discretization d = discretize(forest, {}, {});
  REQUIRE(d.hanging.hanging_count() > 20);
  for (int node = 0; node < d.hanging.node_count(); ++node) {
    const int first = d.hanging.row_start[node];
    if (!d.hanging.hangs(node) || d.hanging.row_start[node + 1] < first + 2 || generator() % 3 != 0) continue;
    d.hanging.weight[first] += 4.0;
    d.hanging.weight[first + 1] -= 4.0;
  }
  REQUIRE(smallest_weight(d.hanging) < -0.1);
  const std::vector<int> scaled = cells_with_scaled_mass(d);
  REQUIRE(!scaled.empty());
  REQUIRE(std::is_sorted(scaled.begin(), scaled.end()));
  const Eigen::VectorXd row_sums = reduced_mass(forest, d, 1.0), mass = lumped_mass(d, 1.0);
  CHECK(mass.minCoeff() > 0.0);
  CHECK_THAT(mass.sum(), WithinRel(1.0, 1e-12));
  // Away from the scaled cells it is the row sum.
  std::vector<char> touched(d.hanging.reduced_count(), 0);
  for (const int cell : scaled)
    for (int k = d.scatter.node_start[cell]; k < d.scatter.node_start[cell + 1]; ++k) touched[d.scatter.nodes[k]] = 1;
  int same = 0, other = 0;
  for (int i = 0; i < d.hanging.reduced_count(); ++i) {
    const bool equal = std::abs(mass[i] - row_sums[i]) <= 1e-12 * std::abs(row_sums[i]);
    if (!touched[i]) CHECK(equal);
    ++(equal ? same : other);
  }
  CHECK(same > 0);
  CHECK(other > 0);
  CHECK(row_sums.minCoeff() < -1e-3);  // kg of one: what the rule is for

  // Of cells that are partly filled the material counts, in scaled cells too.
  Mesh partly_filled = forest.leaf_mesh();
  double material = 0.0;
  CellGeometry scratch;
  for (int cell = 0; cell < partly_filled.cell_count(); ++cell) {
    partly_filled.fraction.push_back(cell % 3 == 0 ? 1.0 : 0.25);
    material += partly_filled.fraction.back() * d.shapes.geometry(d.mesh, cell, scratch).volume;
  }
  Discretization cut = discretize(forest, std::move(partly_filled), {}, {});
  cut.hanging.weight = d.hanging.weight;
  REQUIRE(!cells_with_scaled_mass(cut).empty());
  CHECK_THAT(lumped_mass(cut, 1.0).sum(), WithinRel(material, 1e-12));
}

TEST_CASE("a body twice as large has eight times the mass, to the last bit", "[lumped_mass]") {
  std::mt19937 generator(4);
  const RefinementForest forest = random_body({}, generator);
  Discretization d = discretize(forest, {}, {});
  const Eigen::VectorXd mass = lumped_mass(d, 3.0);
  BaseMesh larger = forest.base();
  larger.nodes *= 2.0;
  generator.seed(4);
  RefinementForest twice = replay(larger, recipe_of(forest), generator);
  d = discretize(twice, {}, {});
  CHECK(same_bits(lumped_mass(d, 3.0), 8.0 * mass));
}
