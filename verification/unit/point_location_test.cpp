#include "core/mesh/point_location.hpp"

#include <cmath>
#include <limits>

#include "verification/support/catch.hpp"
#include "verification/support/deformed_body.hpp"

using namespace finegauge;

TEST_CASE("a located point is the one that the deformation has carried there", "[location]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u, 3u, 4u, 5u, 6u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  const DeformedBody body = deformed_body(shape, 25, generator);
  REQUIRE(body.hanging.hanging_count() > 10);
  REQUIRE(least_stretch(body.mesh, body.u) > 0.1);
  const Eigen::Matrix3Xd positions = body.positions();
  const Eigen::Matrix3Xd field = smooth_field(body.mesh, body.hanging);
  double position_error = 0.0, rest_error = 0.0, field_error = 0.0, hint_error = 0.0;
  int missed = 0, elsewhere = 0;
  for (int k = 0; k < 400; ++k) {
    const LeafPoint asked = random_leaf_point(body.mesh, generator);
    const Eigen::Vector3d x = interpolate(body.mesh, positions, asked);
    const int wrong_hint = static_cast<int>(generator() % static_cast<unsigned>(body.mesh.cell_count()));
    const auto found = locate_deformed(body.mesh, body.u, x);
    const auto hinted = locate_deformed(body.mesh, body.u, x, asked.cell);
    const auto misled = locate_deformed(body.mesh, body.u, x, wrong_hint);
    if (!found || !hinted || !misled) {
      ++missed;
      continue;
    }
    const LeafPoint leaf = find_leaf(body.forest, body.mesh, *found);
    elsewhere += leaf.cell != asked.cell;
    position_error = std::max(position_error, (interpolate(body.mesh, positions, leaf) - x).norm());
    rest_error =
        std::max(rest_error,
                 (rest_position(body.forest.base(), *found) - interpolate(body.mesh, body.mesh.nodes, asked)).norm());
    const Eigen::Vector3d value = interpolate(body.mesh, field, asked);
    field_error = std::max(field_error, (interpolate(body.mesh, field, leaf) - value).norm());
    for (const auto& other : {hinted, misled})
      hint_error = std::max(hint_error,
                            (interpolate(body.mesh, field, find_leaf(body.forest, body.mesh, *other)) - value).norm());
  }
  CHECK(missed == 0);
  CHECK(elsewhere > 20);  // points on faces that another leaf shares
  // Positions are of the size of 3: a few roundings; the inverse map magnifies them by the stretch, above 0.1.
  CHECK_THAT(position_error, WithinAbs(0.0, 1e-14));
  CHECK_THAT(rest_error, WithinAbs(0.0, 5e-14));
  CHECK_THAT(field_error, WithinAbs(0.0, 1e-13));
  CHECK_THAT(hint_error, WithinAbs(0.0, 1e-13));
}

TEST_CASE("a point of the body at rest is found in its base cell", "[location]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  CAPTURE(static_cast<int>(shape));
  std::mt19937 generator(11);
  const RefinementForest forest = deformed_body(shape, 0, generator).forest;
  const Mesh mesh = forest.leaf_mesh();
  double error = 0.0;
  for (int k = 0; k < 1000; ++k) {
    const LeafPoint asked = random_leaf_point(mesh, generator);
    const Eigen::Vector3d X = rest_position(forest.base(), {asked.cell, asked.xi});
    const int hint = k % 2 ? -1 : static_cast<int>(generator() % static_cast<unsigned>(mesh.cell_count()));
    const auto found = locate_at_rest(forest.base(), X, hint);
    REQUIRE(found);
    CHECK((found->xi.minCoeff() >= 0.0 && found->xi.maxCoeff() <= 1.0));
    error = std::max(error, (rest_position(forest.base(), *found) - X).norm());
  }
  CHECK_THAT(error, WithinAbs(0.0, 2e-15));
  CHECK_FALSE(locate_at_rest(forest.base(), {0.0, 0.0, 0.5 + 1e-8}));
  CHECK_FALSE(locate_at_rest(forest.base(), {std::nan(""), 0.0, 0.0}));
  CHECK_FALSE(locate_at_rest(forest.base(), {0.0, std::numeric_limits<double>::infinity(), 0.0}));
  // Less than the slack outside: the nearest point of the body.
  const auto edge = locate_at_rest(forest.base(), {0.1, 0.05, 0.5 + 1e-11});
  REQUIRE(edge);
  CHECK_THAT(rest_position(forest.base(), *edge).z(), WithinAbs(0.5, 1e-15));
}

TEST_CASE("points outside the deformed body are nowhere, those as near inside are found", "[location]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u, 3u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  const DeformedBody body = deformed_body(shape, 25, generator);
  const Eigen::Matrix3Xd positions = body.positions();
  int outside_found = 0, inside_missed = 0, tried = 0;
  for (const BoundaryFace& face : body.mesh.boundary) {
    // Near the middle of the face, off it by a millionth of its size: the body has no other part there.
    const auto& corners = face_corners(shape, face.face);
    std::array<Eigen::Vector3d, 4> p;
    for (int c = 0; c < face_corner_count(shape); ++c) p[c] = positions.col(body.mesh.cells[face.cell][corners[c]]);
    if (shape == CellShape::tetrahedron) p[3] = (p[1] + p[2]) - p[0];  // only for the size
    const Eigen::Vector3d middle = shape == CellShape::hexahedron ? Eigen::Vector3d(0.25 * (p[0] + p[1] + p[2] + p[3]))
                                                                  : Eigen::Vector3d((p[0] + p[1] + p[2]) / 3.0);
    const auto hit = nearest_surface_point(body.mesh, body.u, middle, 1e-9);
    REQUIRE(hit);
    const Eigen::Vector3d off = 1e-6 * (p[1] - p[0]).norm() * hit->inward;
    outside_found += locate_deformed(body.mesh, body.u, middle - off, face.cell).has_value();
    inside_missed += !locate_deformed(body.mesh, body.u, middle + off).has_value();
    ++tried;
  }
  CHECK(tried > 50);
  CHECK(outside_found == 0);
  CHECK(inside_missed == 0);
  CHECK_FALSE(locate_deformed(body.mesh, body.u, {50.0, 0.0, 0.0}, 3));
  CHECK_FALSE(locate_deformed(body.mesh, body.u, Eigen::Vector3d::Constant(std::nan("")), 3));
}

TEST_CASE("a material point keeps its rest position through refinement and coarsening", "[location]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u, 3u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  RefinementForest forest = deformed_body(shape, 0, generator).forest;
  const auto templates = all_templates(shape);
  std::vector<MaterialPoint> points;
  for (int k = 0; k < 100; ++k) {
    const LeafPoint point = random_leaf_point(forest.leaf_mesh(), generator);
    points.push_back({point.cell, point.xi});
    // Halves, thirds and quarters: faces of leaves to come.
    if (shape == CellShape::hexahedron && k % 2)
      for (double& xi : points.back().xi) xi = std::round(12.0 * xi) / 12.0;
  }
  double error = 0.0, there_and_back = 0.0;
  bool coarsened = false;
  for (int step = 0; step < 12; ++step) {
    if (step % 3 == 2) {
      for (const int family : families(forest))
        if (generator() % 2) forest.coarsen(family), coarsened = true;
    } else {
      refine_randomly(forest, {templates, 15, 6, 1500}, generator);
    }
    const Mesh mesh = forest.leaf_mesh();
    for (const MaterialPoint& point : points) {
      const LeafPoint leaf = find_leaf(forest, mesh, point);
      REQUIRE((leaf.cell >= 0 && leaf.cell < mesh.cell_count()));
      CHECK(mesh.frames[leaf.cell].base_cell == point.base_cell);
      const Eigen::Vector3d X = rest_position(forest.base(), point);
      error = std::max(error, (interpolate(mesh, mesh.nodes, leaf) - X).norm());
      there_and_back = std::max(there_and_back, (material_point(mesh, leaf).xi - point.xi).norm());
    }
  }
  REQUIRE(coarsened);
  CHECK_THAT(error, WithinAbs(0.0, 1e-15));  // the body's size is one
  CHECK_THAT(there_and_back, WithinAbs(0.0, 2e-15));
}

TEST_CASE("a leaf a billionth of its base cell is found and located in", "[location][depth]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  BoxMeshOptions options;
  options.shape = shape;
  options.cells = {2, 2, 2};
  RefinementForest forest(box_mesh(options));
  int leaf = 3;
  for (int level = 0; level < 30 && forest.can_refine(leaf, {}); ++level) {
    forest.refine(leaf, {});
    leaf = forest.cell(leaf).first_child + 7;
  }
  REQUIRE(forest.cell(leaf).depth >= 29);
  const Mesh mesh = forest.leaf_mesh();
  const Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (const double share : {0.0, 0.25, 1.0 / 3.0}) {
      const LeafPoint asked{cell, Eigen::Vector3d::Constant(share)};
      const Eigen::Vector3d X = interpolate(mesh, mesh.nodes, asked);
      const LeafPoint found = find_leaf(forest, mesh, material_point(mesh, asked));
      CHECK((interpolate(mesh, mesh.nodes, found) - X).norm() < 1e-15);
      const auto located = locate_deformed(mesh, u, X);
      REQUIRE(located);
      CHECK((rest_position(forest.base(), *located) - X).norm() < 1e-15);
    }
}

TEST_CASE("a scene scaled by a power of two is located to the same bits", "[location][scale]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  std::mt19937 generator(8);
  const DeformedBody body = deformed_body(shape, 25, generator);
  for (const double factor : {0x1p-11, 0x1p10}) {
    Mesh scaled = body.mesh;
    scaled.nodes *= factor;
    const Eigen::Matrix3Xd u = factor * body.u;
    for (int k = 0; k < 100; ++k) {
      const Eigen::Vector3d x = interpolate(body.mesh, body.positions(), random_leaf_point(body.mesh, generator));
      const auto a = locate_deformed(body.mesh, body.u, x), b = locate_deformed(scaled, u, factor * x);
      REQUIRE((a && b));
      CHECK(a->base_cell == b->base_cell);
      CHECK(a->xi == b->xi);
      const Eigen::Vector3d from = x + 5.0 * random_vector(generator);
      const auto hit = first_entry(body.mesh, body.u, from, x),
                 scaled_hit = first_entry(scaled, u, factor * from, factor * x);
      REQUIRE(hit.has_value() == scaled_hit.has_value());
      if (hit) CHECK((hit->point.xi == scaled_hit->point.xi && hit->fraction == scaled_hit->fraction));
      const auto near = nearest_surface_point(body.mesh, body.u, from, 10.0);
      const auto scaled_near = nearest_surface_point(scaled, u, factor * from, factor * 10.0);
      REQUIRE((near && scaled_near));
      CHECK(near->point.xi == scaled_near->point.xi);
    }
  }
}

TEST_CASE("points of strongly distorted cells are found", "[location]") {
  // Newton's method from the centre does not find all of them.
  std::mt19937 generator(21);
  int tried = 0;
  double error = 0.0;
  while (tried < 300) {
    BaseMesh mesh = box_mesh({});
    for (int node = 0; node < 8; ++node) mesh.nodes.col(node) += 0.45 * random_vector(generator);
    double least = 1e300;
    for (int k = 0; k < 1000; ++k) {
      const Eigen::Vector3d xi(k % 10 / 9.0, k / 10 % 10 / 9.0, k / 100 / 9.0);
      Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
      const auto dN = shape_gradients(CellShape::hexahedron, xi);
      for (int c = 0; c < 8; ++c) J += mesh.nodes.col(mesh.cells[0][c]) * dN.col(c).transpose();
      least = std::min(least, J.determinant());
    }
    if (least < 0.02) continue;
    ++tried;
    for (int k = 0; k < 30; ++k) {
      Eigen::Vector3d xi = (Eigen::Vector3d::Ones() + random_vector(generator)) / 2.0;
      if (k % 2) xi = xi.array().round();
      const Eigen::Vector3d X = rest_position(mesh, {0, xi});
      const auto found = locate_at_rest(mesh, X);
      REQUIRE(found);
      error = std::max(error, (rest_position(mesh, *found) - X).norm());
    }
  }
  CHECK_THAT(error, WithinAbs(0.0, 1e-14));
}
