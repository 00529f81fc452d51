#include "benchmarks/program/section.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <stdexcept>

#include "core/mesh/base_mesh.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/deformed_body.hpp"

using namespace finegauge;

namespace {

double double_area(const std::vector<CellSection>& sections) {
  double area = 0.0;
  for (const CellSection& section : sections) area += std::abs(signed_double_area(section.polygon));
  return area;
}

RefinementForest unit_cube(CellShape shape, int cells, bool refined) {
  BoxMeshOptions options;
  options.cells = {cells, cells, cells};
  options.shape = shape;
  RefinementForest forest(box_mesh(options));
  if (refined) {
    const std::vector<int> handles = forest.leaf_mesh().forest_cell;
    for (std::size_t k = 0; k < handles.size(); k += 3) forest.refine(handles[k], {});
  }
  return forest;
}

SectionPlane plane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  return {point, normal.normalized(), normal.unitOrthogonal()};
}

/// A sphere of radius 1 around the origin, its triangles' corners on it; a vertex on each axis.
TriangleSurface sphere(int divisions) {
  TriangleSurface surface;
  surface.vertices.resize(3, 6);
  surface.vertices << 1, -1, 0, 0, 0, 0, 0, 0, 1, -1, 0, 0, 0, 0, 0, 0, 1, -1;
  surface.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int k = 0; k < divisions; ++k) {
    std::map<std::pair<int, int>, int> middles;
    std::vector<std::array<int, 3>> triangles;
    const auto middle = [&](int a, int b) {
      const auto [at, made] = middles.try_emplace({std::min(a, b), std::max(a, b)}, surface.vertices.cols());
      if (made) {
        surface.vertices.conservativeResize(3, surface.vertices.cols() + 1);
        surface.vertices.rightCols<1>() = (surface.vertices.col(a) + surface.vertices.col(b)).normalized();
      }
      return at->second;
    };
    for (const auto& [a, b, c] : surface.triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const std::array<int, 3>& triangle : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        triangles.push_back(triangle);
    }
    surface.triangles = triangles;
  }
  return surface;
}

}  // namespace

TEST_CASE("a plane along the needle draws the needle from left to right, and up upwards", "[section]") {
  const Eigen::Vector3d point(1.0, -2.0, 0.5), direction(0.3, 2.0, -0.4);
  const SectionPlane cut = plane_along(point, direction, Eigen::Vector3d::UnitZ());
  CHECK_THAT(cut.normal.norm(), WithinRel(1.0, 1e-14));
  CHECK_THAT(cut.up.norm(), WithinRel(1.0, 1e-14));
  CHECK(std::abs(cut.normal.dot(cut.up)) < 1e-15);
  CHECK(std::abs(cut.normal.dot(direction)) < 1e-15);
  CHECK(cut.up.z() > 0.9);
  CHECK((cut(point + direction) - Eigen::Vector2d(direction.norm(), 0.0)).norm() < 1e-14);
  CHECK((cut(point + 3.0 * cut.up + 7.0 * cut.normal) - Eigen::Vector2d(0.0, 3.0)).norm() < 1e-14);
  const SectionPlane steep = plane_along(point, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ());
  CHECK(std::abs(steep.normal.z()) < 1e-15);
  CHECK_THAT(steep.up.norm(), WithinRel(1.0, 1e-14));
}

TEST_CASE("the cells' sections fill the body's, whatever is refined", "[section]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const bool refined = GENERATE(false, true);
  CAPTURE(shape == CellShape::hexahedron, refined);
  const RefinementForest forest = unit_cube(shape, 3, refined);
  const Mesh mesh = forest.leaf_mesh();
  // The hexagon through the middle of a cube, and what is left of it farther out: a triangle with sides sqrt(2) s.
  const Eigen::Vector3d diagonal = Eigen::Vector3d::Ones();
  const auto cut = [&](const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
    return section_of_cells(mesh, mesh.nodes, plane(point, normal));
  };
  // section_offset moves the plane by 1e-6 of the diagonal: areas change by a few times that.
  const double slack = 1e-5;
  CHECK_THAT(double_area(cut(0.5 * diagonal, diagonal)), WithinRel(1.5 * std::sqrt(3.0), slack));
  CHECK_THAT(double_area(cut(0.1 * diagonal, diagonal)), WithinRel(std::sqrt(3.0) * 0.09, slack * 10));
  CHECK_THAT(double_area(cut(0.4 * diagonal, {0.0, 1.0, 0.0})), WithinRel(2.0, slack));
  CHECK(cut(1.1 * diagonal, diagonal).empty());
  if (refined) REQUIRE(mesh.cell_count() > (shape == CellShape::hexahedron ? 27 : 162));
}

TEST_CASE("a plane through nodes cuts one cell of the two beside it, whatever round-off has done to them",
          "[section]") {
  const Mesh mesh = unit_cube(CellShape::hexahedron, 2, true).leaf_mesh();
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(-1e-13, 1e-13);
  Eigen::Matrix3Xd positions = mesh.nodes;
  const SectionPlane middle = plane({0.5, 0.5, 0.5}, Eigen::Vector3d::UnitY());
  const auto exact = section_of_cells(mesh, positions, middle);
  for (double& x : positions.reshaped()) x += uniform(generator);
  const auto disturbed = section_of_cells(mesh, positions, middle);
  CHECK_THAT(double_area(exact), WithinRel(2.0, 1e-9));
  CHECK_THAT(double_area(disturbed), WithinRel(2.0, 1e-9));
  REQUIRE(exact.size() == disturbed.size());
  for (std::size_t k = 0; k < exact.size(); ++k) {
    CHECK(exact[k].cell == disturbed[k].cell);
    CHECK(exact[k].polygon.size() == 4);
    CHECK(disturbed[k].polygon.size() == 4);
  }
}

TEST_CASE("a face with corners to either side in turns is cut around its middle, the same in both cells", "[section]") {
  BoxMeshOptions options;
  options.cells = {1, 1, 2};
  options.size = {1.0, 1.0, 2.0};
  const Mesh mesh = RefinementForest(box_mesh(options)).leaf_mesh();
  Eigen::Matrix3Xd positions = mesh.nodes;
  for (int node = 0; node < mesh.node_count(); ++node)
    if (const Eigen::Vector3d X = mesh.nodes.col(node); X.z() == 1.0) positions(2, node) += X.x() == X.y() ? 0.3 : -0.1;
  // The face's middle is 0.1 above the plane, so that the plane's middle lies in the lower cell.
  const auto sections = section_of_cells(mesh, positions, plane({0.0, 0.0, 1.0}, Eigen::Vector3d::UnitZ()));
  std::array<int, 2> polygons{};
  std::array<double, 2> areas{};
  for (const CellSection& section : sections) {
    ++polygons[section.cell];
    areas[section.cell] += 0.5 * std::abs(signed_double_area(section.polygon));
  }
  CHECK(polygons == std::array{1, 2});
  CHECK_THAT(areas[0] + areas[1], WithinRel(1.0, 1e-9));
  CHECK_THAT(areas[1], WithinRel(0.25 * 0.25, 1e-4));  // two corners with legs of a quarter
}

TEST_CASE("a body that is sheared has its sheared section", "[section]") {
  const Mesh mesh = unit_cube(CellShape::hexahedron, 3, true).leaf_mesh();
  const Eigen::Matrix3d F = (Eigen::Matrix3d() << 1.2, 0.3, -0.1, 0.0, 0.9, 0.2, 0.1, 0.0, 1.1).finished();
  const Eigen::Vector3d point(0.3, 0.4, 0.6), normal = Eigen::Vector3d(1.0, 0.4, -0.3).normalized();
  // Areas of planes go with the cofactor of F (Nanson): the section at x = F X is that at X with normal Fᵀ n.
  const auto sheared = section_of_cells(mesh, F * mesh.nodes, plane(F * point, normal));
  const auto straight = section_of_cells(mesh, mesh.nodes, plane(point, F.transpose() * normal));
  CHECK_THAT(double_area(sheared) * (F.transpose() * normal).norm(),
             WithinRel(F.determinant() * double_area(straight), 1e-4));
}

TEST_CASE("sections of a bent, refined and turned body have no gap and no overlap", "[section]") {
  std::mt19937 generator(17);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const DeformedBody body = deformed_body(shape, 12, generator, 0.1);
  REQUIRE(body.hanging.hanging_count() > 0);
  // The volume as an integral of section areas, midpoint rule, against that of the cells.
  const Eigen::Matrix3Xd x = body.positions();
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, 1.0, 0.5).normalized();
  const Eigen::RowVectorXd height = normal.transpose() * x;
  constexpr int slices = 200;
  const double low = height.minCoeff(), step = (height.maxCoeff() - low) / slices;
  double volume = 0.0;
  for (int k = 0; k < slices; ++k)
    volume +=
        0.5 * step * double_area(section_of_cells(body.mesh, x, plane((low + (k + 0.5) * step) * normal, normal)));
  double exact = 0.0;
  for (int cell = 0; cell < body.mesh.cell_count(); ++cell) {
    // Gauss points of two in each direction are exact for a trilinear map; a tetrahedron's determinant is constant.
    const double g = 0.5 / std::sqrt(3.0);
    const bool hexahedron = shape == CellShape::hexahedron;
    for (int q = 0; q < (hexahedron ? 8 : 1); ++q) {
      const Eigen::Vector3d xi(0.5 + (q & 1 ? g : -g), 0.5 + (q & 2 ? g : -g), 0.5 + (q & 4 ? g : -g));
      const Eigen::Matrix3d F = corner_values(body.mesh, cell, x) * shape_gradients(shape, xi).transpose();
      exact += std::abs(F.determinant()) / (hexahedron ? 8.0 : 6.0);
    }
  }
  CHECK_THAT(volume, WithinRel(exact, 2e-3));  // slices 1e-4; lines across warped faces are no farther off than 1e-3
}

TEST_CASE("a closed surface is cut in closed polygons, through its vertices, too", "[section]") {
  const TriangleSurface surface = sphere(4);
  const double height = GENERATE(0.0, 0.3, -0.6);
  CAPTURE(height);
  for (const Eigen::Vector3d& normal : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1, 2, 3)}) {
    const auto polygons = section_of_surface(surface, plane(height * normal.normalized(), normal));
    REQUIRE(polygons.size() == 1);
    // Inside of the sphere by no more than a triangle's sagitta, h²/8 = 1/800 for 32 triangles around a quarter.
    const double circle = 2.0 * std::numbers::pi * (1.0 - height * height),
                 area = std::abs(signed_double_area(polygons[0]));
    CHECK(area < circle * (1.0 + 1e-5));
    CHECK(area > circle * 0.99);
    CHECK(polygons[0].size() > 32);
  }
  TriangleSurface two = surface;
  two.vertices.conservativeResize(3, 2 * surface.vertices.cols());
  two.vertices.rightCols(surface.vertices.cols()) = surface.vertices.colwise() + Eigen::Vector3d(3.0, 0.0, 0.0);
  for (const auto& [a, b, c] : surface.triangles) {
    const int n = static_cast<int>(surface.vertices.cols());
    two.triangles.push_back({a + n, b + n, c + n});
  }
  CHECK(section_of_surface(two, plane({0.0, 0.0, height}, Eigen::Vector3d::UnitZ())).size() == 2);
  two.triangles.resize(surface.triangles.size() + 40);  // the second one open
  CHECK(section_of_surface(two, plane({0.0, 0.0, height}, Eigen::Vector3d::UnitZ())).size() == 1);
}

TEST_CASE("a surface is carried along as the body is, and is part of it", "[section]") {
  RefinementForest forest = unit_cube(CellShape::hexahedron, 3, true);
  const Mesh mesh = forest.leaf_mesh();
  TriangleSurface surface = sphere(2);
  surface.vertices = 0.4 * surface.vertices;
  surface.vertices.colwise() += Eigen::Vector3d(0.5, 0.5, 0.5);
  const std::vector<MaterialPoint> points = points_of_surface(forest.base(), surface);
  const Eigen::Matrix3d G = (Eigen::Matrix3d() << 0.2, 0.3, -0.1, 0.0, -0.1, 0.2, 0.1, 0.0, 0.1).finished();
  const TriangleSurface carried = carried_surface(surface, points, forest, mesh, G * mesh.nodes);
  CHECK(carried.triangles == surface.triangles);
  CHECK((carried.vertices - surface.vertices - G * surface.vertices).cwiseAbs().maxCoeff() < 1e-12);
  // A thorn out of the cells goes with the nearest of their points.
  surface.vertices.col(7) << 0.3, 0.4, 1.001;
  const TriangleSurface thorn =
      carried_surface(surface, points_of_surface(forest.base(), surface), forest, mesh, G * mesh.nodes);
  CHECK((thorn.vertices.col(7) - surface.vertices.col(7) - G * Eigen::Vector3d(0.3, 0.4, 1.0)).norm() < 1e-12);
  surface.vertices(2, 7) = 2.5;
  CHECK_THROWS_AS(points_of_surface(forest.base(), surface), std::invalid_argument);
}
