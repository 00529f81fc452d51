#include "core/needle/tissue_coupling.hpp"

#include <cmath>
#include <numbers>
#include <set>

#include "verification/support/catch.hpp"
#include "verification/support/deformed_body.hpp"

using namespace finegauge;

namespace {

Eigen::Vector3d centroid(const BaseMesh& base, const SpreadPoint& spread) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < spread.points.size(); ++k)
    mean += spread.weights[k] * rest_position(base, spread.points[k]);
  return mean;
}

double weight_sum(const std::vector<double>& weights) {
  double sum = 0.0;
  for (const double w : weights) sum += w;
  return sum;
}

}  // namespace

TEST_CASE("a ring of any axis has its centre for centroid, across cells too", "[coupling]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u, 3u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  const DeformedBody body = deformed_body(shape, 20, generator);
  const BaseMesh& base = body.forest.base();
  int across = 0, whole = 0, dropped = 0;
  double off_centre = 0.0, off_radius = 0.0, off_plane = 0.0, off_linear = 0.0;
  Eigen::Matrix3Xd linear = random_matrix(generator) * body.mesh.nodes;
  for (int k = 0; k < 200; ++k) {
    const LeafPoint at = random_leaf_point(body.mesh, generator);
    const MaterialPoint centre = material_point(body.mesh, at);
    const Eigen::Vector3d axis = 10.0 * random_vector(generator), X = rest_position(base, centre);
    const double radius = 0.3;
    const SpreadPoint spread = spread_over_ring(base, centre, axis, radius, 8);
    REQUIRE(spread.points.size() == spread.weights.size());
    REQUIRE((spread.points.size() % 2 == 0 || spread.points.size() == 1));
    CHECK_THAT(weight_sum(spread.weights), WithinAbs(1.0, 1e-15));
    whole += spread.points.size() == 8;
    dropped += spread.points.size() < 8;
    off_centre = std::max(off_centre, (centroid(base, spread) - X).norm());
    const Eigen::Vector3d sampled = spread_value(body.forest, body.mesh, linear, spread);
    off_linear = std::max(off_linear, (sampled - interpolate(body.mesh, linear, at)).norm());
    if (spread.points.size() == 1) continue;
    std::set<int> cells;
    for (const MaterialPoint& point : spread.points) {
      const Eigen::Vector3d arm = rest_position(base, point) - X;
      off_radius = std::max(off_radius, std::abs(arm.norm() - radius));
      off_plane = std::max(off_plane, std::abs(arm.dot(axis.normalized())));
      cells.insert(point.base_cell);
    }
    across += cells.size() > 1;
  }
  CHECK(whole > 20);
  CHECK(dropped > 20);
  CHECK(across > 20);
  CHECK_THAT(off_centre, WithinAbs(0.0, 1e-15));
  CHECK_THAT(off_linear, WithinAbs(0.0, 4e-15));
  CHECK_THAT(off_radius, WithinAbs(0.0, 2e-15));
  CHECK_THAT(off_plane, WithinAbs(0.0, 2e-15));
}

TEST_CASE("near the boundary a ring loses opposite points together", "[coupling]") {
  const RefinementForest forest(box_mesh({}));
  const MaterialPoint middle{0, {0.5, 0.5, 0.5}}, low{0, {0.5, 0.5, 0.1}}, corner{0, {0.05, 0.05, 0.05}};
  const Eigen::Vector3d x_axis = Eigen::Vector3d::UnitX(), z_axis = Eigen::Vector3d::UnitZ();
  CHECK(spread_over_ring(forest.base(), middle, z_axis, 0.2).points.size() == 8);
  CHECK(spread_over_ring(forest.base(), low, z_axis, 0.2).points.size() == 8);
  // Across x, offsets of more than 0.1 along z leave the body: of eight points the two along y stay.
  const SpreadPoint cut = spread_over_ring(forest.base(), low, x_axis, 0.2);
  CHECK(cut.points.size() == 2);
  CHECK((centroid(forest.base(), cut) - rest_position(forest.base(), low)).norm() < 1e-15);
  for (const SpreadPoint& alone : {spread_over_ring(forest.base(), corner, {1.0, 1.0, 1.0}, 0.3),
                                   spread_over_ring(forest.base(), middle, z_axis, 0.0)}) {
    REQUIRE(alone.points.size() == 1);
    CHECK(alone.weights.front() == 1.0);
    CHECK(alone.points.front().base_cell == alone.centre.base_cell);
    CHECK(alone.points.front().xi == alone.centre.xi);
  }
  // A ring outside by less than the slack of the location: moving its points in would move its centroid.
  const SpreadPoint touching = spread_over_ring(forest.base(), {0, {0.5, 0.5, 0.2}}, x_axis, 0.2 + 1e-11);
  CHECK((centroid(forest.base(), touching) - Eigen::Vector3d(0.5, 0.5, 0.2)).norm() < 1e-15);
}

TEST_CASE("reduced weights are the interpolation through T, merged and ascending", "[coupling][hanging]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u, 3u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  const DeformedBody body = deformed_body(shape, 30, generator);
  REQUIRE(body.hanging.hanging_count() > 10);
  const Eigen::SparseMatrix<double> T = interpolation_matrix(body.hanging);
  double difference = 0.0;
  int through_masters = 0;
  ReducedWeights weights;
  for (int k = 0; k < 100; ++k) {
    const MaterialPoint centre = material_point(body.mesh, random_leaf_point(body.mesh, generator));
    const SpreadPoint spread = spread_over_ring(body.forest.base(), centre, random_vector(generator), k % 3 * 0.1);
    find_reduced_weights(body.forest, body.mesh, body.hanging, spread, weights);
    CHECK_THAT(weight_sum(weights.weight), WithinAbs(1.0, 1e-14));
    CHECK(std::adjacent_find(weights.node.begin(), weights.node.end(), std::greater_equal<>()) == weights.node.end());
    // Dense: the row of shape functions at all nodes, times T; its first component of three.
    Eigen::VectorXd row = Eigen::VectorXd::Zero(3 * body.mesh.node_count());
    for (std::size_t p = 0; p < spread.points.size(); ++p) {
      const LeafPoint leaf = find_leaf(body.forest, body.mesh, spread.points[p]);
      const auto N = shape_functions(shape, leaf.xi);
      for (int c = 0; c < corner_count(shape); ++c) {
        const int node = body.mesh.cells[leaf.cell][c];
        row[3 * node] += spread.weights[p] * N[c];
        through_masters += N[c] > 0.0 && body.hanging.hangs(node);
      }
    }
    Eigen::VectorXd expected = T.transpose() * row;
    for (std::size_t w = 0; w < weights.node.size(); ++w) expected[3 * weights.node[w]] -= weights.weight[w];
    difference = std::max(difference, expected.cwiseAbs().maxCoeff());
  }
  CHECK(through_masters > 50);
  CHECK_THAT(difference, WithinAbs(0.0, 1e-15));
}

TEST_CASE("reduced weights and the field itself give one position", "[coupling]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  std::mt19937 generator(7);
  const DeformedBody body = deformed_body(shape, 30, generator);
  const Eigen::VectorXd x_reduced = gather(body.hanging, body.positions());
  ReducedWeights weights;
  double difference = 0.0, spread_apart = 0.0;
  for (int k = 0; k < 100; ++k) {
    const MaterialPoint centre = material_point(body.mesh, random_leaf_point(body.mesh, generator));
    const SpreadPoint spread = spread_over_ring(body.forest.base(), centre, random_vector(generator), 0.15);
    find_reduced_weights(body.forest, body.mesh, body.hanging, spread, weights);
    Eigen::Vector3d x = -spread_position(body.forest, body.mesh, body.u, spread);
    for (std::size_t w = 0; w < weights.node.size(); ++w)
      x += weights.weight[w] * x_reduced.segment<3>(3 * weights.node[w]);
    difference = std::max(difference, x.norm());
    const Eigen::Vector3d alone = interpolate(body.mesh, body.positions(), find_leaf(body.forest, body.mesh, centre));
    spread_apart = std::max(spread_apart, (spread_position(body.forest, body.mesh, body.u, spread) - alone).norm());
  }
  CHECK_THAT(difference, WithinAbs(0.0, 5e-15));
  CHECK(spread_apart > 1e-4);  // the deformation is not linear, so mean and centre differ
}

TEST_CASE("reduced weights keep their storage", "[coupling]") {
  std::mt19937 generator(3);
  const DeformedBody body = deformed_body(CellShape::hexahedron, 30, generator);
  std::vector<SpreadPoint> spreads;
  for (int k = 0; k < 50; ++k)
    spreads.push_back(spread_over_ring(body.forest.base(),
                                       material_point(body.mesh, random_leaf_point(body.mesh, generator)),
                                       random_vector(generator), 0.2));
  ReducedWeights weights;
  std::size_t largest = 0;
  for (const SpreadPoint& spread : spreads) {
    find_reduced_weights(body.forest, body.mesh, body.hanging, spread, weights);
    largest = std::max(largest, weights.node.size());
  }
  REQUIRE(largest > 20);
  const int* const nodes = weights.node.data();
  const double* const values = weights.weight.data();
  for (const SpreadPoint& spread : spreads) find_reduced_weights(body.forest, body.mesh, body.hanging, spread, weights);
  CHECK(weights.node.data() == nodes);
  CHECK(weights.weight.data() == values);
}
