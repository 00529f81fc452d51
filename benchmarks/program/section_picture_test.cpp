#include "benchmarks/program/section_picture.hpp"

#include <array>
#include <cstdio>
#include <limits>
#include <set>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/occurrences.hpp"

using namespace finegauge;

namespace {

/// 4 × 2 × 2 cells, one of them refined, cut along x at half its depth.
struct Body {
  Mesh mesh;
  SectionPictureOptions options;
};
Body body() {
  BoxMeshOptions box;
  box.size = {0.04, 0.02, 0.02};
  box.cells = {4, 2, 2};
  RefinementForest forest(box_mesh(box));
  forest.refine(0, {});
  Body made{forest.leaf_mesh(), {}};
  made.options.plane = plane_along({0.0, 0.01, 0.01}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ());
  return made;
}
const Eigen::Matrix3Xd at_rest(3, 0);

/// Corners of the n-th cell's path [px].
std::vector<Eigen::Vector2d> cell_path(const std::string& svg, int n) {
  std::size_t at = 0;
  for (int k = 0; k <= n; ++k) at = svg.find("class=\"cell\"", at + 1);
  const char* text = svg.c_str() + svg.find(" d=\"", at) + 4;
  std::vector<Eigen::Vector2d> corners;
  double x = 0.0, y = 0.0;
  for (int length = 0; std::sscanf(text, "%*[ML]%lf %lf%n", &x, &y, &length) == 2; text += length)
    corners.emplace_back(x, y);
  return corners;
}

}  // namespace

TEST_CASE("each cell that the plane cuts is drawn once, in the colour of its value", "[picture][section]") {
  const auto [mesh, options] = body();
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(mesh.cell_count(), 0.0, 7.0);
  const std::vector<CellSection> cut = section_of_cells(mesh, mesh.nodes, options.plane);
  // On the far side of the plane seven cells of 1 cm and the refined one's four on its near face.
  CHECK(cut.size() == (cut.front().cell < 8 ? 11 : 8));
  const std::string svg = section_picture_svg(mesh, at_rest, values, options);
  CHECK(occurrences(svg, "class=\"cell\"") == static_cast<int>(cut.size()));
  CHECK(svg == section_picture_svg(mesh, at_rest, values, options));
  CHECK(svg.find(std::to_string(cut.size()) + " cut by the plane") != std::string::npos);
  std::set<std::string> colors;
  for (std::size_t at = svg.find("class=\"cell\""); at != std::string::npos; at = svg.find("class=\"cell\"", at + 1))
    colors.insert(svg.substr(svg.find("fill=\"", at) + 6, 7));
  CHECK(colors.size() >= cut.size() - 1);  // the last ones end the range together
  CHECK(colors.contains("#440154"));
  CHECK(colors.contains("#fde725"));
}

TEST_CASE("a picture keeps the body's proportions, with x to the right and z upwards", "[picture][section]") {
  const auto [mesh, options] = body();
  const std::string svg = section_picture_svg(mesh, at_rest, Eigen::VectorXd::Zero(mesh.cell_count()), options);
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  const std::vector<CellSection> cut = section_of_cells(mesh, mesh.nodes, options.plane);
  for (std::size_t k = 0; k < cut.size(); ++k) {
    const auto corners = cell_path(svg, static_cast<int>(k));
    REQUIRE(corners.size() == cut[k].polygon.size());
    for (std::size_t c = 0; c < corners.size(); ++c) {
      low = low.cwiseMin(corners[c]), high = high.cwiseMax(corners[c]);
      for (std::size_t other = 0; other < c; ++other) {
        const Eigen::Vector2d drawn = corners[c] - corners[other], real = cut[k].polygon[c] - cut[k].polygon[other];
        CHECK(drawn.x() * real.x() >= 0.0);
        CHECK(drawn.y() * real.y() <= 0.0);
      }
    }
  }
  CHECK_THAT((high - low).x() / (high - low).y(), WithinRel(2.0, 1e-3));  // a tenth of a pixel of some hundred
  CHECK((low.x() >= 40.0 && high.x() <= options.width - 200.0 && low.y() >= 80.0 && high.y() <= options.height - 50.0));
}

TEST_CASE("cells are drawn inside of the outline only, where there is one", "[picture][section]") {
  auto [mesh, options] = body();
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(mesh.cell_count(), 0.0, 1.0);
  const std::string whole = section_picture_svg(mesh, at_rest, values, options);
  CHECK(occurrences(whole, "url(#body)") == 0);
  CHECK(occurrences(whole, "class=\"outline\"") == 0);
  options.outline = {{{0.01, -0.005}, {0.03, -0.005}, {0.02, 0.005}}, {{0.018, -0.003}, {0.022, -0.003}, {0.02, 0.0}}};
  const std::string part = section_picture_svg(mesh, at_rest, values, options);
  const std::size_t clip = part.find("<clipPath id=\"body\">"), group = part.find("<g clip-path=\"url(#body)\">");
  REQUIRE((clip != std::string::npos && group != std::string::npos && clip < group));
  CHECK(part.find("clip-rule=\"evenodd\"", clip) < group);  // the second polygon is a hole
  CHECK(part.find("class=\"cell\"") > group);
  CHECK(part.find("</g>", group) > part.rfind("class=\"cell\""));
  CHECK(occurrences(part, "class=\"outline\"") == 1);
  CHECK(part.find("</g>", group) < part.find("class=\"outline\""));  // the outline itself is not cut in half
}

TEST_CASE("a needle is drawn over the section with its tip in the picture, as thick as it is", "[picture][section]") {
  auto [mesh, options] = body();
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(mesh.cell_count(), 0.0, 1.0);
  CHECK(occurrences(section_picture_svg(mesh, at_rest, values, options), "class=\"needle\"") == 0);
  options.needle.resize(3, 2);
  options.needle << -0.3, -0.02, 0.01, 0.01, 0.01, 0.01;
  const auto needle = [&options = options](const std::string& svg) {
    const std::size_t at = svg.rfind("class=\"needle\"");
    REQUIRE(at != std::string::npos);
    REQUIRE(at > svg.rfind("class=\"edges\""));
    double width = 0.0, x[2], y[2];
    REQUIRE(std::sscanf(svg.c_str() + svg.find("stroke-width", at), "stroke-width=\"%lf\" d=\"M%lf %lfL%lf %lf", &width,
                        &x[0], &y[0], &x[1], &y[1]) == 5);
    CHECK((x[1] > 40.0 && x[1] < options.width - 200.0));
    CHECK((y[1] > 84.0 && y[1] < options.height - 60.0));
    CHECK(x[0] < x[1]);
    return std::array{width, (x[1] - x[0]) / 0.28};
  };
  const auto thin = needle(section_picture_svg(mesh, at_rest, values, options));
  CHECK(thin[0] == 4.0);
  CHECK(occurrences(section_picture_svg(mesh, at_rest, values, options), "stroke-opacity=\"0.55\"") == 0);
  options.needle_radius = 1e-3;
  const auto thick = needle(section_picture_svg(mesh, at_rest, values, options));
  CHECK_THAT(thick[0], WithinAbs(2e-3 * thick[1], 0.06));
  CHECK(thick[0] > 10.0);
  CHECK(occurrences(section_picture_svg(mesh, at_rest, values, options), "stroke-opacity=\"0.55\"") == 1);
}

TEST_CASE("the scale bar is a round length, drawn to scale", "[picture][section]") {
  auto [mesh, options] = body();
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(mesh.cell_count(), 0.0, 1.0);
  const double size = GENERATE(1.0, 0.013, 70.0);
  mesh.nodes *= size;
  options.plane.point *= size;
  const std::string svg = section_picture_svg(mesh, at_rest, values, options);
  double width = 0.0, length = 0.0;
  const std::size_t bar = svg.find("class=\"scale\"");
  REQUIRE(bar != std::string::npos);
  REQUIRE(std::sscanf(svg.c_str() + svg.find("-5h", bar), "-5h%lf", &width) == 1);
  char unit[8] = {};
  REQUIRE(std::sscanf(svg.c_str() + svg.find("fill=\"#222222\">", bar), "fill=\"#222222\">%lf %2[m]", &length, unit) ==
          2);
  if (std::string(unit) == "mm") length *= 1e-3;
  const auto corners = cell_path(svg, 0);
  const auto cut = section_of_cells(mesh, mesh.nodes, options.plane);
  CHECK_THAT(width / length,
             WithinRel((corners[0] - corners[2]).norm() / (cut[0].polygon[0] - cut[0].polygon[2]).norm(), 5e-3));
  CHECK(width > 0.08 * options.width);
  CHECK(width < 0.25 * options.width);
}

TEST_CASE("values that are none are grey, and one value everywhere is light", "[picture][section]") {
  const auto [mesh, options] = body();
  const int cut = static_cast<int>(section_of_cells(mesh, mesh.nodes, options.plane).size());
  Eigen::VectorXd values = Eigen::VectorXd::Constant(mesh.cell_count(), std::numeric_limits<double>::quiet_NaN());
  const std::string none = section_picture_svg(mesh, at_rest, values, options);
  CHECK(occurrences(none, "fill=\"#bbbbbb\"") == cut);
  CHECK(none.find("nan") == std::string::npos);
  values = Eigen::VectorXd::LinSpaced(mesh.cell_count(), 3.0, 3.1);
  CHECK(occurrences(section_picture_svg(mesh, at_rest, values, options), "fill=\"#cfe3ec\"") == 0);
  SectionPictureOptions coarse = options;
  coarse.resolution = 0.2;
  CHECK(occurrences(section_picture_svg(mesh, at_rest, values, coarse), "fill=\"#cfe3ec\"") == cut);
  values.setConstant(3.0);
  const std::string one = section_picture_svg(mesh, at_rest, values, options);
  CHECK(occurrences(one, "fill=\"#cfe3ec\"") == cut);
  CHECK(one.find("uniform: 3<") != std::string::npos);
}

TEST_CASE("cells count for the range of colours as far as they are material", "[picture][section]") {
  auto [mesh, options] = body();
  const int cut = section_of_cells(mesh, mesh.nodes, options.plane)[3].cell;
  Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(mesh.cell_count(), 0.0, 1.0);
  values[cut] = 50.0;
  const auto largest = [&, &mesh = mesh, &options = options] {
    return section_picture_svg(mesh, at_rest, values, options);
  };
  options.upper_quantile = 1.0;
  CHECK(largest().find(">50<") != std::string::npos);
  mesh.fraction.assign(static_cast<std::size_t>(mesh.cell_count()), 1.0);
  CHECK(largest().find(">50<") != std::string::npos);
  mesh.fraction[static_cast<std::size_t>(cut)] = 0.0;
  CHECK(largest().find(">50<") == std::string::npos);
  options.upper_quantile = 0.98;
  mesh.fraction[static_cast<std::size_t>(cut)] = 0.01;  // a sliver does not stretch the range, but is told of
  CHECK(largest().find("largest 50<") != std::string::npos);
  CHECK(largest().find("≥ 50<") == std::string::npos);
}

TEST_CASE("a plane that misses the body gives an empty picture without a number that is none", "[picture][section]") {
  auto [mesh, options] = body();
  options.plane.point.y() = 3.0;
  const std::string svg = section_picture_svg(mesh, at_rest, Eigen::VectorXd::Ones(mesh.cell_count()), options);
  CHECK(occurrences(svg, "class=\"cell\"") == 0);
  CHECK(svg.find("nan") == std::string::npos);
  CHECK(svg.find("inf") == std::string::npos);
  CHECK(svg.find("0 cut by the plane") != std::string::npos);
}
