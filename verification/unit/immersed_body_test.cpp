#include "core/mesh/immersed_body.hpp"

#include <cmath>
#include <limits>

#include "core/mesh/material_share.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;
using Eigen::Vector3d;

namespace {

std::string refusal(const TriangleSurface& surface, const ImmersedMeshOptions& options) {
  try {
    (void)immersed_mesh(surface, options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

const ImmersedMeshOptions tenths = {Vector3d::Constant(0.1), {}};

/// By solid angles: 0 or 1, or -1 where the surface is so near that a neighbour gets another answer.
int inside(const TriangleSurface& surface, const Vector3d& X) {
  const double winding = std::round(winding_number(surface, X));
  for (const int corner : {0, 3, 5, 6}) {
    const Vector3d shift = Vector3d(corner & 1, (corner >> 1) & 1, corner >> 2) - Vector3d::Constant(0.5);
    if (std::abs(winding_number(surface, X + 1e-7 * shift) - winding) > 1e-6) return -1;
  }
  return static_cast<int>(winding);
}

}  // namespace

TEST_CASE("points are inside where the surface winds around them", "[immersed][contains]") {
  std::mt19937 generator(3);
  const std::array<TriangleSurface, 4> surfaces = {
      icosphere(6, 0.8), closed_ellipsoid(5, {1.0, 0.4, 0.6}), closed_box({1.2, 0.8, 0.5}, {0.1, 0, 0}, oblique_turn()),
      affine_image(oblique_turn(), {0, 0, 0}, closed_torus(0.7, 0.2, 24, 12))};
  for (const TriangleSurface& surface : surfaces) {
    const BaseMesh mesh = immersed_mesh(surface, {Vector3d(0.21, 0.17, 0.33), {}});
    int in = 0, out = 0, wrong = 0;
    for (int sample = 0; sample < 4000; ++sample) {
      const Vector3d X = 1.2 * random_vector(generator);
      const int expected = inside(surface, X);
      if (expected < 0) continue;
      wrong += contains(*mesh.body, X) != (expected == 1);
      ++(expected ? in : out);
    }
    CHECK(wrong == 0);
    CHECK(in > 100);
    CHECK(out > 1000);
  }
}

TEST_CASE("a ray through vertices and along edges and walls counts nothing twice", "[immersed][contains]") {
  std::mt19937 generator(5);
  for (const TriangleSurface& surface :
       {icosphere(4, 0.8, {0.1, 0.3, -0.2}), closed_torus(0.7, 0.2, 16, 8),
        closed_box({1.0, 0.5, 0.7}, {0.3, 0.1, 0.2}, Eigen::Matrix3d::Identity(), 4)}) {
    const BaseMesh mesh = immersed_mesh(surface, {Vector3d::Constant(0.1), {}});
    const ImmersedBody& body = *mesh.body;
    int in = 0, out = 0, wrong = 0;
    for (Eigen::Index v = 0; v < surface.vertices.cols(); ++v)
      for (int sample = 0; sample < 24; ++sample) {
        Vector3d X = surface.vertices.col(v);
        X.z() += 1.5 * random_number(generator);
        // The scan line through a vertex, but beside it.
        if (sample % 3 == 2) X.x() += 0.7 * random_number(generator);
        // Middles of edges, projected: exact where the edge is parallel to an axis.
        if (sample % 3 == 1) {
          const auto& t = surface.triangles[generator() % surface.triangles.size()];
          X.head<2>() = 0.5 * (surface.vertices.col(t[0]) + surface.vertices.col(t[1])).head<2>();
        }
        const int expected = inside(surface, X);
        if (expected < 0) continue;
        wrong += contains(body, X) != (expected == 1);
        ++(expected ? in : out);
      }
    CHECK(wrong == 0);
    CHECK(in > 100);
    CHECK(out > 100);
  }
  // Through the vertices: the lattice coordinates agree bit by bit.
  const BaseMesh mesh = immersed_mesh(icosphere(4, 0.8), tenths);
  const Vector3d V = mesh.body->surface.vertices.col(5);
  CHECK((V - mesh.body->origin).cwiseQuotient(mesh.body->cell_size) == mesh.body->lattice_vertices.col(5));
}

TEST_CASE("a box in lattice planes holds the lattice points inside and none outside", "[immersed][contains]") {
  const int divisions = GENERATE(1, 2, 5);
  const BaseMesh mesh =
      immersed_mesh(closed_box({1.0, 0.75, 0.5}, {0.5, 0.375, 0.25}, Eigen::Matrix3d::Identity(), divisions),
                    {Vector3d::Constant(0.125), Vector3d::Zero()});
  REQUIRE(mesh.cells.size() == 8 * 6 * 4);
  int in = 0, on = 0;
  for (int k = -2; k <= 6; ++k)
    for (int j = -2; j <= 8; ++j)
      for (int i = -2; i <= 10; ++i) {
        const bool strictly_inside = i > 0 && i < 8 && j > 0 && j < 6 && k > 0 && k < 4;
        const bool outside = i < 0 || i > 8 || j < 0 || j > 6 || k < 0 || k > 4;
        const bool answer = contains(*mesh.body, 0.125 * Vector3d(i, j, k));
        CAPTURE(i, j, k);
        if (strictly_inside) CHECK(answer);
        if (outside) CHECK_FALSE(answer);
        in += answer;
        on += answer && !strictly_inside;
      }
  // Points on the surface belong to one side by the half-open rule: each cell of the lattice owns one lattice point.
  CHECK(in == 8 * 6 * 4);
  CHECK(on == 8 * 6 * 4 - 7 * 5 * 3);
}

TEST_CASE("the default lattice is the smallest that holds the body, centred, or keeps a given corner", "[immersed]") {
  const TriangleSurface surface = icosphere(8, 0.43, {0.2, 0.5, -0.3});
  const BoundingBox box = bounding_box(surface);
  const BaseMesh mesh = immersed_mesh(surface, tenths);
  CHECK(mesh.body->lattice_cells == std::array{9, 9, 9});
  const Vector3d upper = lattice_position(*mesh.body, {9, 9, 9});
  CHECK(((box.lower - mesh.body->origin) - (upper - box.upper)).norm() < 1e-15);
  const BaseMesh given = immersed_mesh(surface, {Vector3d::Constant(0.1), Vector3d(7.03, -2.51, 0.0)});
  const Vector3d cells = (Vector3d(7.03, -2.51, 0.0) - given.body->origin) / 0.1;
  CHECK((cells - cells.array().round().matrix()).norm() < 1e-12);
  CHECK((box.lower - given.body->origin).minCoeff() >= 0.0);
  CHECK((box.lower - given.body->origin).maxCoeff() < 0.1);
  CHECK(given.cells.size() != mesh.cells.size());  // or the origin did nothing
}

TEST_CASE("base cells are those that hold material, in the order of the lattice, with shared nodes", "[immersed]") {
  const BaseMesh mesh = immersed_mesh(closed_torus(0.3, 0.11, 40, 20), tenths);
  const ImmersedBody& body = *mesh.body;
  CHECK(validate(mesh).empty());
  CHECK(std::is_sorted(body.place.begin(), body.place.end(), [](const auto& a, const auto& b) {
    return std::tuple(a[2], a[1], a[0]) < std::tuple(b[2], b[1], b[0]);
  }));
  CHECK(static_cast<int>(mesh.cells.size()) < body.lattice_cells[0] * body.lattice_cells[1] * body.lattice_cells[2]);
  CHECK(static_cast<double>(mesh.nodes.cols()) < 3.0 * static_cast<double>(mesh.cells.size()));
  // The hole of the ring is no cell, and every cell's neighbour with material is there.
  for (const auto& place : body.place)
    CHECK_FALSE((place[0] == body.lattice_cells[0] / 2 && place[1] == body.lattice_cells[1] / 2));
  for (int k = 0; k < body.lattice_cells[2]; ++k)
    for (int j = 0; j < body.lattice_cells[1]; ++j)
      for (int i = 0; i < body.lattice_cells[0]; ++i) {
        const bool exists = std::find(body.place.begin(), body.place.end(), std::array{i, j, k}) != body.place.end();
        const double share = integrated_share(body, {Vector3d(i, j, k), Vector3d(i + 1, j + 1, k + 1)});
        CHECK(exists == (share > least_base_share));
      }
}

TEST_CASE("what is no body or no lattice is refused in words", "[immersed]") {
  const TriangleSurface ball = icosphere(3, 0.5);
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  CHECK(refusal(ball, tenths) == "accepted");
  CHECK_THAT(refusal(TriangleSurface{}, tenths), ContainsSubstring("no triangles"));
  CHECK_THAT(refusal(turned_inside_out(ball), tenths), ContainsSubstring("counter-clockwise"));
  for (const double h : {0.0, -0.1, nan, infinity}) {
    CHECK_THAT(refusal(ball, {Vector3d(0.1, h, 0.1), {}}), ContainsSubstring("cell size along y"));
  }
  CHECK_THAT(refusal(ball, {}), ContainsSubstring("cell size along x is 0"));
  CHECK_THAT(refusal(ball, {Vector3d::Constant(0.1), Vector3d(0, 0, nan)}), ContainsSubstring("origin along z"));
  CHECK_THAT(refusal(ball, {Vector3d::Constant(1e-3), {}}), ContainsSubstring("more than 4000000 cells"));
  CHECK_THAT(refusal(ball, {Vector3d::Constant(1e-300), {}}), ContainsSubstring("more than 4000000 cells"));
  CHECK_THAT(refusal(ball, {Vector3d::Constant(100.0), {}}),
             ContainsSubstring("accepted"));  // one cell, a share of 5e-7
  CHECK_THAT(refusal(ball, {Vector3d::Constant(1e4), {}}), ContainsSubstring("are cells too large"));

  TriangleSurface broken = ball;
  broken.triangles.pop_back();
  CHECK_THAT(refusal(broken, tenths), ContainsSubstring("not closed at the edge from ("));
  broken = ball;
  std::swap(broken.triangles[7][0], broken.triangles[7][1]);
  CHECK_THAT(refusal(broken, tenths), ContainsSubstring("not closed at the edge from ("));
  broken = ball;
  broken.triangles[3][1] = static_cast<int>(ball.vertices.cols());
  CHECK_THAT(refusal(broken, tenths), ContainsSubstring("triangle 3 has vertex"));
  broken = ball;
  broken.vertices(1, broken.triangles[0][0]) = nan;
  CHECK_THAT(refusal(broken, tenths), ContainsSubstring("must be finite"));
  // The same ball twice encloses its points twice.
  broken = ball;
  broken.triangles.insert(broken.triangles.end(), ball.triangles.begin(), ball.triangles.end());
  CHECK_THAT(refusal(broken, tenths), ContainsSubstring("times its volume"));
}

TEST_CASE("an origin so far off that rounding leaves no lattice around the body is refused", "[immersed]") {
  const auto refusal_at = [](double origin) {
    return refusal(icosphere(2, 0.3), {Vector3d::Constant(0.1), Vector3d(0.0, origin, 0.0)});
  };
  for (const double origin : {0.0, -1e3, 1e6}) CHECK(refusal_at(origin) == "accepted");
  for (const double origin : {1e15, 1e16, -1e17, 1e40, 1e300}) {
    CAPTURE(origin);
    const std::string words = refusal_at(origin);
    CHECK(words.find("origin along y is ") == 0);
    CHECK(words.find("rounding leaves no lattice around it") != std::string::npos);
  }
}

TEST_CASE("vertices that no triangle uses and vertices given twice change nothing", "[immersed]") {
  const TriangleSurface ball = icosphere(4, 0.5, {0.1, 0.2, 0.3});
  TriangleSurface soup;  // each triangle with corners of its own, and a stray vertex that is not a number
  soup.vertices.resize(3, 3 * ball.triangle_count() + 1);
  for (int triangle = 0; triangle < ball.triangle_count(); ++triangle) {
    soup.vertices.middleCols<3>(3 * triangle) = triangle_corners(ball, triangle);
    soup.triangles.push_back({3 * triangle, 3 * triangle + 1, 3 * triangle + 2});
  }
  soup.vertices.rightCols<1>().setConstant(std::numeric_limits<double>::quiet_NaN());
  const BaseMesh mesh = immersed_mesh(ball, tenths), other = immersed_mesh(soup, tenths);
  CHECK(mesh.body->share == other.body->share);
  CHECK(mesh.body->place == other.body->place);
  std::mt19937 generator(2);
  for (int sample = 0; sample < 500; ++sample) {
    const Vector3d X = random_vector(generator);
    CHECK(contains(*mesh.body, X) == contains(*other.body, X));
  }
}

TEST_CASE("a forest refuses a base mesh that is not its body's lattice", "[immersed][forest]") {
  const BaseMesh mesh = immersed_mesh(icosphere(3, 0.25), tenths);
  CHECK_NOTHROW(RefinementForest(mesh));
  BaseMesh other = mesh;
  other.nodes.col(4).x() += 1e-9;
  CHECK_THROWS_AS(RefinementForest(other), std::invalid_argument);
  other = mesh;
  other.cells.pop_back();
  CHECK_FALSE(validate(*other.body, other).empty());
  auto body = *mesh.body;
  body.share[3] = 1.5;
  CHECK_FALSE(validate(body, mesh).empty());
  // A share that is possible but not the body's is found by the forest.
  body.share[3] = 0.5 * mesh.body->share[3];
  other = mesh;
  other.body = std::make_shared<const ImmersedBody>(body);
  CHECK(validate(RefinementForest(mesh)).empty());
  CHECK_FALSE(validate(RefinementForest(other)).empty());
}

TEST_CASE("refinements of an immersed body undone leave every bit, in any order", "[immersed][forest][reversibility]") {
  std::mt19937 generator(23);
  const auto templates = all_templates();
  const BaseMesh base = immersed_mesh(closed_torus(0.3, 0.11, 30, 16), tenths);
  RefinementForest forest(base);
  const Mesh start = forest.leaf_mesh();
  REQUIRE(start.fraction == base.body->share);
  for (int cycle = 0; cycle < 3; ++cycle) {
    REQUIRE(refine_randomly(forest, {templates, 60, 5, 4000}, generator) > 20);
    REQUIRE(validate(forest).empty());
    RefinementForest again = replay(base, recipe_of(forest), generator);
    CHECK(validate(again).empty());
    CHECK(same_bits(forest.leaf_mesh(), again.leaf_mesh()));
    coarsen_randomly(forest, {}, generator);
    CHECK(same_bits(start, forest.leaf_mesh(), true));
  }
}

TEST_CASE("shares stay numbers as deep as the forest goes", "[immersed][forest]") {
  const BaseMesh base = immersed_mesh(icosphere(4, 0.37, {1.0, 2.0, 3.0}), tenths);
  RefinementForest forest(base);
  for (int axis = 0; axis < 2; ++axis) {
    int leaf = 5, depth = 0;
    RefinementTemplate refinement{{4, 4, 4}};
    for (; depth < 60; ++depth) {
      if (!forest.can_refine(leaf, refinement)) refinement = {{3, 3, 3}};
      if (!forest.can_refine(leaf, refinement)) break;
      forest.refine(leaf, refinement);
      const int first = forest.cell(leaf).first_child;
      leaf = first;
      for (int child = first; child < first + refinement.child_count(); ++child) {
        const double share = forest.cell(child).share;
        REQUIRE((share >= 0.0 && share <= 1.0));
        if (share > 0.0 && share < 1.0) leaf = child;  // along the surface
      }
    }
    CHECK(depth == 15 + 21);
    REQUIRE(validate(forest).empty());
    while (!forest.is_leaf(5)) {
      int family = leaf;
      while (!forest.can_coarsen(family)) family = forest.cell(family).parent;
      forest.coarsen(family);
      leaf = family;
    }
  }
}

TEST_CASE("without a body there are no fractions and every cell is full", "[immersed][forest]") {
  RefinementForest forest(box_mesh({}));
  forest.refine(0, {{2, 3, 2}});
  CHECK(forest.leaf_mesh().fraction.empty());
  CHECK(forest.cell(forest.cell(0).first_child).share == 1.0);
  CHECK(material_share(forest.leaf_mesh(), 3) == 1.0);
}
