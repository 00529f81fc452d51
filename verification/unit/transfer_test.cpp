#include "core/space/transfer.hpp"

#include <map>

#include "core/mesh/nested_meshes.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/conformity.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

RefinementForest random_forest(CellShape shape, std::mt19937& generator) {
  BoxMeshOptions options;
  options.cells = shape == CellShape::hexahedron ? std::array{2, 2, 1} : std::array{1, 1, 1};
  options.shape = shape;
  RefinementForest forest(scrambled(distorted_box(options, 0.1, generator), generator));
  const auto templates = all_templates(shape);
  refine_randomly(forest, {templates, 8, 3, 300}, generator);
  return forest;
}

Eigen::Matrix3Xd conforming_field(const RefinementForest& forest, const Mesh& mesh, std::mt19937& generator) {
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  REQUIRE(hanging.hanging_count() > 0);
  Eigen::VectorXd reduced(3 * hanging.reduced_count());
  for (double& value : reduced) value = random_number(generator);
  return expand(hanging, reduced);
}

/// The largest difference of two fields at random points of the finer mesh's leaves, by their own interpolations.
double largest_difference(const Mesh& coarse, const Eigen::Matrix3Xd& u, const Mesh& fine, const Eigen::Matrix3Xd& v,
                          std::mt19937& generator) {
  const CellShape shape = fine.shape;
  double difference = 0.0;
  for (int cell = 0; cell < fine.cell_count(); ++cell)
    for (int k = 0; k < 3; ++k) {
      // A mean of the leaf's corners with whole weights of sum 64.
      std::array<unsigned, max_corners> share{};
      for (int i = 0; i < 64; ++i) ++share[generator() % static_cast<unsigned>(corner_count(shape))];
      LatticePoint point{};
      for (int c = 0; c < corner_count(shape); ++c)
        for (int axis = 0; axis < 3; ++axis)
          point[axis] += lattice_corner(shape, fine.frames[cell], c)[axis] / 64 * share[c];
      const auto value = [&](const Mesh& mesh, int leaf, const Eigen::Matrix3Xd& field) {
        const auto N = shape_functions(shape, natural_coordinates(shape, mesh.frames[leaf], point));
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int a = 0; a < corner_count(shape); ++a) sum += N[a] * field.col(mesh.cells[leaf][a]);
        return sum;
      };
      int holder = -1;
      for (int other = 0; other < coarse.cell_count() && holder < 0; ++other) {
        if (coarse.frames[other].base_cell != fine.frames[cell].base_cell) continue;
        const Eigen::Vector3d xi = natural_coordinates(shape, coarse.frames[other], point);
        const double highest = shape == CellShape::hexahedron ? xi.maxCoeff() : xi.sum();
        if (xi.minCoeff() > -1e-9 && highest < 1.0 + 1e-9) holder = other;
      }
      REQUIRE(holder >= 0);
      difference = std::max(difference, (value(coarse, holder, u) - value(fine, cell, v)).cwiseAbs().maxCoeff());
    }
  return difference;
}

}  // namespace

TEST_CASE("refinement keeps a conforming field exactly, and coarsening again brings it back", "[transfer]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u, 3u, 4u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  RefinementForest forest = random_forest(shape, generator);
  const Mesh before = forest.leaf_mesh();
  const Eigen::Matrix3Xd u = conforming_field(forest, before, generator);
  const auto templates = all_templates(shape);
  std::vector<int> refined;
  for (const int leaf : leaves(forest))
    if (generator() % 3 == 0) {
      forest.refine(leaf, templates[generator() % templates.size()]);
      refined.push_back(leaf);
    }
  const Mesh fine = forest.leaf_mesh();
  REQUIRE(fine.cell_count() > before.cell_count());
  const Eigen::Matrix3Xd v = transfer(before, u, fine);
  CHECK_THAT(largest_difference(before, u, fine, v, generator), WithinAbs(0.0, 1e-12));
  CHECK_THAT(largest_jump(forest, fine, v, 6, 3), WithinAbs(0.0, 1e-12));
  for (const int leaf : refined) forest.coarsen(leaf);
  const Mesh after = forest.leaf_mesh();
  // Hanging nodes may be interpolated from another leaf that holds them: the same value up to round-off.
  CHECK((transfer(fine, v, after) - u).cwiseAbs().maxCoeff() <= 1e-13);
}

TEST_CASE("coarsening keeps the values at the nodes that remain", "[transfer]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(5u, 6u, 7u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  RefinementForest forest = random_forest(shape, generator);
  const Mesh before = forest.leaf_mesh();
  const Eigen::Matrix3Xd u = conforming_field(forest, before, generator);
  for (const int family : families(forest)) forest.coarsen(family);
  const Mesh coarse = forest.leaf_mesh();
  REQUIRE(coarse.cell_count() < before.cell_count());
  const Eigen::Matrix3Xd v = transfer(before, u, coarse);
  const auto key = [](const NodeIdentity& id) { return std::pair(id.entity, id.at); };
  std::map<std::pair<std::uint64_t, LatticePoint>, int> node_before;
  for (int node = 0; node < before.node_count(); ++node) node_before[key(before.identities[node])] = node;
  for (int node = 0; node < coarse.node_count(); ++node) {
    REQUIRE(node_before.count(key(coarse.identities[node])) == 1);
    const int old = node_before[key(coarse.identities[node])];
    // A hanging node may be interpolated from an old leaf around it instead of copied: the same value to round-off.
    CHECK((v.col(node) - u.col(old)).norm() <= 1e-13);
  }
}

TEST_CASE("a field on the same mesh is itself", "[transfer]") {
  std::mt19937 generator(8);
  RefinementForest forest = random_forest(CellShape::hexahedron, generator);
  const Mesh mesh = forest.leaf_mesh();
  const Eigen::Matrix3Xd u = conforming_field(forest, mesh, generator);
  CHECK(same_bits(transfer(mesh, u, mesh), u));
}
