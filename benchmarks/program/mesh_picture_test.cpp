#include "benchmarks/program/mesh_picture.hpp"

#include <cstdio>
#include <limits>
#include <string>

#include "benchmarks/program/svg_colors.hpp"
#include "core/mesh/base_mesh.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/occurrences.hpp"

using namespace finegauge;

namespace {

Mesh box(CellShape shape) {
  RefinementForest forest(box_mesh({.cells = {2, 2, 2}, .shape = shape, .removed = {}}));
  forest.refine(forest.leaf_mesh().forest_cell[0], {});
  return forest.leaf_mesh();
}

const Eigen::Matrix3Xd no_displacement(3, 0);

}  // namespace

TEST_CASE("the colour map runs from viridis' dark violet to its yellow and grows lighter all the way", "[picture]") {
  CHECK_THAT(viridis(0.0)[0], WithinAbs(0x44 / 255.0, 1e-12));
  CHECK_THAT(viridis(0.5)[1], WithinAbs(0x91 / 255.0, 1e-12));
  CHECK_THAT(viridis(1.0)[2], WithinAbs(0x25 / 255.0, 1e-12));
  CHECK(viridis(-3.0) == viridis(0.0));
  CHECK(viridis(7.0) == viridis(1.0));
  const auto luminance = [](double t) {
    const auto rgb = viridis(t);
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
  };
  for (int k = 0; k < 100; ++k) CHECK(luminance((k + 1) / 100.0) > luminance(k / 100.0));
}

TEST_CASE("a picture shows the faces that look at the viewer and not the others", "[picture]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Mesh mesh = box(shape);
  // A linear field that is 1 on x = 1 and falls to 0 at x = 0; seen along x from either side it is one colour.
  const Eigen::VectorXd nodal = mesh.nodes.row(0);
  MeshPictureOptions options;
  options.view = {1.0, 0.0, 0.0};
  const std::string front = mesh_picture_svg(mesh, nodal, no_displacement, options);
  options.view = {-1.0, 0.0, 0.0};
  const std::string back = mesh_picture_svg(mesh, nodal, no_displacement, options);
  REQUIRE(occurrences(front, "<path stroke=\"none\"") > 100);
  CHECK(front.find(">uniform: 1<") != std::string::npos);
  CHECK(back.find(">uniform: 0<") != std::string::npos);
}

TEST_CASE("a field of one value is drawn light, however it is rounded, and one that varies is not", "[picture]") {
  const Mesh mesh = box(CellShape::hexahedron);
  Eigen::VectorXd nodal = Eigen::VectorXd::Constant(mesh.node_count(), 5.0);
  nodal += 1e-6 * mesh.nodes.row(0).transpose();  // below the three digits that a label shows
  const std::string uniform = mesh_picture_svg(mesh, nodal, no_displacement);
  CHECK(uniform.find(">uniform: 5<") != std::string::npos);
  CHECK(occurrences(uniform, "fill=\"#cfe3ec\" d=") == occurrences(uniform, "<path stroke=\"none\""));
  CHECK(occurrences(uniform, "<rect") == 1);  // the background, and no colour bar
  nodal += mesh.nodes.row(0).transpose();
  const std::string varied = mesh_picture_svg(mesh, nodal, no_displacement);
  CHECK(varied.find("uniform") == std::string::npos);
  CHECK(occurrences(varied, "#cfe3ec") == 0);
  CHECK(occurrences(varied, "<rect") > 10);
}

TEST_CASE("values that are not finite are drawn grey and leave the colour bar alone", "[picture]") {
  const Mesh mesh = box(CellShape::hexahedron);
  Eigen::VectorXd nodal = mesh.nodes.row(2);
  const std::string whole = mesh_picture_svg(mesh, nodal, no_displacement);
  CHECK(occurrences(whole, "#bbbbbb") == 0);
  nodal.setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::string none = mesh_picture_svg(mesh, nodal, no_displacement);
  CHECK(occurrences(none, "#bbbbbb") == occurrences(none, "<path stroke=\"none\""));
  CHECK(occurrences(none, "#bbbbbb") > 100);
  CHECK(none.find("nan") == std::string::npos);
}

TEST_CASE("titles are text, whatever characters they have", "[picture]") {
  MeshPictureOptions options;
  options.title = "a < b & c";
  const Mesh mesh = box(CellShape::hexahedron);
  const std::string svg = mesh_picture_svg(mesh, Eigen::VectorXd(mesh.nodes.row(0)), no_displacement, options);
  CHECK(svg.find("a &lt; b &amp; c") != std::string::npos);
}

TEST_CASE("the suggested scale draws the largest displacement at a twentieth of the diagonal", "[picture]") {
  const Mesh mesh = box(CellShape::hexahedron);
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  CHECK(suggested_deformation_scale(mesh, u) == 1.0);
  u(1, 3) = 1e-3;  // 0.05 sqrt(3) / 1e-3 = 86.6, cut to one digit
  CHECK_THAT(suggested_deformation_scale(mesh, u), WithinRel(80.0, 1e-12));
  u(1, 3) = 0.5;  // a sixth of it would be a twentieth of the diagonal
  CHECK(suggested_deformation_scale(mesh, u) == 1.0);
}

TEST_CASE("a curve is drawn over the body, and the picture has room for all of it", "[picture]") {
  const Mesh mesh = RefinementForest(box_mesh({.removed = {}})).leaf_mesh();
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(mesh.node_count(), 0.0, 1.0);
  MeshPictureOptions options;
  const std::string without = mesh_picture_svg(mesh, values, Eigen::Matrix3Xd(3, 0), options);
  options.curve.resize(3, 2);
  options.curve << -10, 0.5, 0.5, 0.5, 0.5, 0.5;
  const std::string with = mesh_picture_svg(mesh, values, Eigen::Matrix3Xd(3, 0), options);
  CHECK(without.find("stroke-width=\"4\"") == std::string::npos);
  const std::size_t curve = with.find("stroke-width=\"4\"");
  REQUIRE(curve != std::string::npos);
  CHECK(curve > with.rfind("crispEdges\" fill=\"#", with.find("<text")));  // after the body, so over it
  double x = 0.0, y = 0.0;
  REQUIRE(std::sscanf(with.c_str() + with.find(" d=\"M", curve), " d=\"M%lf %lf", &x, &y) == 2);
  CHECK((x >= 0.0 && x <= options.width && y >= 0.0 && y <= options.height));
}
