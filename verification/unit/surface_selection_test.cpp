#include "core/mesh/surface_selection.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/mesh/immersed_body.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

double facet_area(const SurfaceFacet& facet) {
  const auto& X = facet.corners;
  return 0.5 * (X[1] - X[0]).cross(X[2] - X[0]).norm();
}

std::vector<int> all_of(const std::vector<SurfaceFacet>& facets) {
  std::vector<int> numbers(facets.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

double total_area(const std::vector<SurfacePoint>& points) {
  double area = 0.0;
  for (const SurfacePoint& point : points) area += point.area;
  return area;
}

/// A surface in a lattice whose cells are base cells where `keep` says so.
template <class Keep>
BaseMesh immersed(TriangleSurface surface, double cell, const Keep& keep) {
  const Eigen::Vector3d low = surface.vertices.rowwise().minCoeff(), high = surface.vertices.rowwise().maxCoeff();
  auto body = std::make_shared<ImmersedBody>();
  body->surface = std::move(surface);
  body->cell_size.setConstant(cell);
  for (int axis = 0; axis < 3; ++axis) {
    body->origin[axis] = low[axis] - 0.3 * cell;
    body->lattice_cells[axis] = static_cast<int>(std::ceil((high[axis] - body->origin[axis]) / cell + 0.1));
  }
  BoxMeshOptions box;
  box.origin = body->origin;
  box.cells = body->lattice_cells;
  for (int axis = 0; axis < 3; ++axis) box.size[axis] = cell * body->lattice_cells[axis];
  const BaseMesh lattice = box_mesh(box);
  BaseMesh mesh;
  mesh.nodes = lattice.nodes;  // nodes without a cell do no harm here
  for (int k = 0, number = 0; k < box.cells[2]; ++k)
    for (int j = 0; j < box.cells[1]; ++j)
      for (int i = 0; i < box.cells[0]; ++i, ++number) {
        const Eigen::Vector3d centre = body->origin + cell * Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5);
        if (!keep(centre)) continue;
        mesh.cells.push_back(lattice.cells[number]);
        body->place.push_back({i, j, k});
      }
  mesh.body = body;
  return mesh;
}
constexpr auto every_cell = [](const Eigen::Vector3d&) { return true; };

}  // namespace

TEST_CASE("the quadrature points of a surface have its area and lie on it", "[surface][springs]") {
  const double cell = GENERATE(0.9, 0.3, 0.11);
  CAPTURE(cell);
  const BaseMesh mesh = immersed(icosphere(3), cell, every_cell);
  const std::vector<SurfaceFacet> facets = surface_facets(mesh);
  REQUIRE(facets.size() == 180);
  double exact = 0.0, longest = 0.0;
  for (const SurfaceFacet& facet : facets) {
    exact += facet_area(facet);
    for (int c = 0; c < 3; ++c) longest = std::max(longest, (facet.corners[(c + 1) % 3] - facet.corners[c]).norm());
  }
  const std::vector<SurfacePoint> points = surface_points(mesh, facets, all_of(facets));
  CHECK_THAT(total_area(points), WithinRel(exact, 1e-12));  // up to 26 000 points in a row
  // Parts are n² of each triangle, n half cells along its longest edge, and up to 2 n more for columns rounded up.
  const double n = std::max(1.0, std::ceil(longest / (0.5 * cell)));
  CHECK(double(points.size()) >= 3.0 * 180 * (n - 1) * (n - 1));
  CHECK(double(points.size()) <= 3.0 * 180 * n * (n + 2));
  for (const SurfacePoint& point : points) {
    REQUIRE((point.at.xi.minCoeff() >= 0.0 && point.at.xi.maxCoeff() <= 1.0));
    const double radius = rest_position(mesh, point.at).norm();
    CHECK((radius <= 1.0 && radius >= 0.95));  // between the sphere and the inner edges of its triangles
  }
}

TEST_CASE("the three-point rule integrates quadratic functions over cut triangles exactly", "[surface][springs]") {
  // ∮ x_i x_j dA over a box turned in space; closed form of each triangle: A/12 (Σ x_c x_cᵀ + s sᵀ), s = Σ x_c.
  const BaseMesh mesh = immersed(closed_box({1.0, 0.7, 0.4}, {0.1, 0.2, 0.3}, oblique_turn()), 0.13, every_cell);
  const std::vector<SurfaceFacet> facets = surface_facets(mesh);
  Eigen::Matrix3d exact = Eigen::Matrix3d::Zero(), found = exact;
  for (const SurfaceFacet& facet : facets) {
    const Eigen::Vector3d s = facet.corners[0] + facet.corners[1] + facet.corners[2];
    Eigen::Matrix3d moment = s * s.transpose();
    for (int c = 0; c < 3; ++c) moment += facet.corners[c] * facet.corners[c].transpose();
    exact += facet_area(facet) / 12.0 * moment;
  }
  for (const SurfacePoint& point : surface_points(mesh, facets, all_of(facets))) {
    const Eigen::Vector3d X = rest_position(mesh, point.at);
    found += point.area * X * X.transpose();
  }
  CHECK((found - exact).norm() <= 1e-13 * exact.norm());
}

TEST_CASE("boundary faces of a mesh have their area, whatever the cells' shape", "[surface][springs]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  std::mt19937 generator(3);
  BoxMeshOptions box;
  box.size = {2.0, 1.0, 0.5};
  box.cells = {3, 2, 2};
  box.shape = shape;
  const BaseMesh mesh = scrambled(distorted_box(box, 0.15, generator), generator);
  const std::vector<SurfaceFacet> facets = surface_facets(mesh);
  const std::vector<SurfacePoint> points = surface_points(mesh, facets, all_of(facets));
  CHECK_THAT(total_area(points), WithinRel(7.0, 1e-13));
  CHECK(points.size() == facets.size() * (shape == CellShape::hexahedron ? 4 : 3));
  // ∮ X dA: the box's middle times its area; and every point is on the box.
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (const SurfacePoint& point : points) {
    const Eigen::Vector3d X = rest_position(mesh, point.at);
    moment += point.area * X;
    CHECK((X.cwiseMin(box.size - X).minCoeff() >= -1e-15 && X.cwiseMin(box.size - X).minCoeff() <= 1e-15));
  }
  CHECK((moment - 3.5 * box.size).norm() <= 1e-13);
}

TEST_CASE("a patch is what lies around the nearest point of the surface", "[surface]") {
  const double unit = GENERATE(1.0, 0x1p-13, 0x1p13);
  const BaseMesh mesh = immersed(icosphere(12, unit), 0.2 * unit, every_cell);
  const std::vector<SurfaceFacet> facets = surface_facets(mesh);
  std::mt19937 generator(11);
  std::size_t most = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d direction = random_vector(generator).normalized();
    const double radius = 0.35 * unit;
    // From inside and from outside the nearest point is that of the sphere to a triangle's edge, 0.1 of the radius.
    for (const double from : {0.8, 1.0, 3.0}) {
      const Selected patch = select_facets(facets, PatchSelection{from * unit * direction, radius});
      most = std::max(most, patch.numbers.size());
      for (std::size_t i = 0; i < facets.size(); ++i) {
        const auto& X = facets[i].corners;
        const double distance = ((X[0] + X[1] + X[2]) / 3.0 - unit * direction).norm() / unit;
        if (std::abs(distance - 0.35) < 0.1) continue;
        CHECK(std::binary_search(patch.numbers.begin(), patch.numbers.end(), int(i)) == (distance < 0.35));
      }
    }
  }
  CHECK(most > 50);
  const Selected none = select_facets(facets, PatchSelection{unit * Eigen::Vector3d(0, 0, 5), 1e-3 * unit});
  REQUIRE(none.numbers.empty());
  CHECK((none.nearest_outside > 0.0 && none.nearest_outside < 0.1 * unit));
  // The same selection in other units, bit by bit.
  const std::vector<SurfaceFacet> plain = surface_facets(immersed(icosphere(12), 0.2, every_cell));
  CHECK(select_facets(facets, PatchSelection{unit * Eigen::Vector3d(0.3, 0.2, 2), 0.4 * unit}).numbers ==
        select_facets(plain, PatchSelection{Eigen::Vector3d(0.3, 0.2, 2), 0.4}).numbers);
}

TEST_CASE("the nearest point is found over faces, edges and corners of the surface", "[surface]") {
  // A patch of radius just above the distance from that point to the nearest centre has this centre alone.
  const BaseMesh mesh = immersed(closed_box({2.0, 2.0, 2.0}), 0.5, every_cell);
  const std::vector<SurfaceFacet> facets = surface_facets(mesh);
  REQUIRE(facets.size() == 12);
  std::mt19937 generator(5);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d p = 2.5 * random_vector(generator);
    if (p.cwiseAbs().maxCoeff() <= 1.0) continue;
    const Eigen::Vector3d nearest = p.cwiseMax(-1.0).cwiseMin(1.0);
    std::vector<double> distances;
    for (const SurfaceFacet& facet : facets)
      distances.push_back(((facet.corners[0] + facet.corners[1] + facet.corners[2]) / 3.0 - nearest).norm());
    std::vector<double> sorted = distances;
    std::sort(sorted.begin(), sorted.end());
    const Selected patch = select_facets(facets, PatchSelection{p, 0.5 * (sorted[2] + sorted[3])});
    if (sorted[3] - sorted[2] < 1e-6) continue;
    REQUIRE(patch.numbers.size() == 3);
    for (const int i : patch.numbers) CHECK(distances[i] <= sorted[2]);
  }
}

TEST_CASE("the cells that triangles touch have every point of them, and each has a point of one", "[surface][region]") {
  const BaseMesh mesh = immersed(icosphere(4), 0.23, every_cell);
  const ImmersedBody& body = *mesh.body;
  const std::vector<SurfaceFacet> facets = surface_facets(mesh);
  const Selected patch = select_facets(facets, PatchSelection{{0.3, 1.0, 0.4}, 0.5});
  REQUIRE(patch.numbers.size() > 5);
  const std::vector<int> cells = touched_cells(mesh, facets, patch.numbers);
  // By brute force: dense samples of the triangles; a cell that is only grazed has its samples near it.
  const int n = 200;
  std::vector<double> nearest(mesh.cells.size(), 1e9);
  for (const int i : patch.numbers)
    for (int a = 0; a <= n; ++a)
      for (int b = 0; a + b <= n; ++b) {
        const auto& X = facets[i].corners;
        const Eigen::Vector3d x = (X[0] * (n - a - b) + X[1] * a + X[2] * b) / n;
        const Eigen::Vector3d s = (x - body.origin).cwiseQuotient(body.cell_size);
        for (std::size_t cell = 0; cell < body.place.size(); ++cell) {
          const Eigen::Vector3d lower(body.place[cell][0], body.place[cell][1], body.place[cell][2]);
          if ((s - lower).minCoeff() < -0.1 || (s - lower).maxCoeff() > 1.1) continue;
          const Eigen::Vector3d outside = (lower - s).cwiseMax(s - lower - Eigen::Vector3d::Ones()).cwiseMax(0.0);
          nearest[cell] = std::min(nearest[cell], outside.maxCoeff());
        }
      }
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
    const bool touched = std::binary_search(cells.begin(), cells.end(), int(cell));
    if (nearest[cell] == 0.0) CHECK(touched);
    if (nearest[cell] > 0.02) CHECK_FALSE(touched);  // twice the spacing of the samples
  }
  CHECK(cells.size() > 5);
  // Their nodes are the clamped ones.
  const Selected nodes = select_nodes(mesh, PatchSelection{{0.3, 1.0, 0.4}, 0.5});
  for (const int cell : cells)
    for (const int node : mesh.cells[cell]) CHECK(std::binary_search(nodes.numbers.begin(), nodes.numbers.end(), node));
  CHECK(nodes.numbers.size() <= 8 * cells.size());
}

TEST_CASE("points in a lattice cell that is no base cell belong to the nearest base cell", "[surface][springs]") {
  // Of the lattice only a cell here and there is kept: the nearest one may be rings away and not in the first ring.
  const double cell = 0.12;
  const auto kept = [](const Eigen::Vector3d& centre) {
    return std::abs(std::fmod(43758.5 * std::sin(centre.dot(Eigen::Vector3d(12.9, 78.2, 37.7))), 1.0)) < 0.02;
  };
  const BaseMesh mesh = immersed(icosphere(3), cell, kept), full = immersed(icosphere(3), cell, every_cell);
  const std::vector<SurfaceFacet> facets = surface_facets(mesh);
  const std::vector<SurfacePoint> points = surface_points(mesh, facets, all_of(facets)),
                                  whole = surface_points(full, facets, all_of(facets));
  REQUIRE(points.size() == whole.size());
  int moved = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    REQUIRE(points[i].at.base_cell >= 0);
    CHECK(points[i].area == whole[i].area);
    const Eigen::Vector3d X = rest_position(mesh, points[i].at), there = rest_position(full, whole[i].at);
    double nearest = 1e9;  // over all base cells
    for (const auto& corners : mesh.cells) {
      const Eigen::Vector3d low = mesh.nodes.col(corners[0]), high = mesh.nodes.col(corners[7]);
      nearest = std::min(nearest, (there.cwiseMax(low).cwiseMin(high) - there).norm());
    }
    CHECK_THAT((X - there).norm(), WithinAbs(nearest, 1e-14));
    moved += nearest > cell;
  }
  CHECK(moved > 100);
}

TEST_CASE("a sliver has as many quadrature points as its length asks for, not the square", "[surface][springs]") {
  TriangleSurface needle = closed_box({1.0, 1e-3, 1e-3});
  const BaseMesh mesh = immersed(needle, 0.02, every_cell);
  const std::vector<SurfaceFacet> facets = surface_facets(mesh);
  const std::vector<SurfacePoint> points = surface_points(mesh, facets, all_of(facets));
  CHECK_THAT(total_area(points), WithinRel(4e-3 + 2e-6, 1e-12));
  // Eight triangles a hundred half cells long: two parts in each strip but the first; four triangles at the ends.
  CHECK(points.size() >= 3 * (8 * 199 + 4));
  CHECK(points.size() <= 3 * (8 * 203 + 4));  // the diagonals are longer by a hair: one strip more
}
