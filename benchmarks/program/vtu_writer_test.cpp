#include "benchmarks/program/vtu_writer.hpp"

#include <unistd.h>

#include <Eigen/Geometry>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

std::vector<unsigned char> decode_base64(const std::string& text) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(alphabet.find(c));
    if ((count += 6) >= 8) bytes.push_back(static_cast<unsigned char>(bits >> (count -= 8)));
  }
  return bytes;
}

/// The values of the array of this name after the given tag.
template <class T>
std::vector<T> read_array(const std::string& vtu, const std::string& section, const std::string& name) {
  const std::size_t tag = vtu.find("Name=\"" + name + "\"", vtu.find("<" + section + ">"));
  REQUIRE(tag != std::string::npos);
  const std::size_t begin = vtu.find('>', tag) + 1;
  const std::vector<unsigned char> bytes = decode_base64(vtu.substr(begin, vtu.find('<', begin) - begin));
  std::uint64_t size = 0;
  REQUIRE(bytes.size() >= sizeof size);
  std::memcpy(&size, bytes.data(), sizeof size);
  REQUIRE(bytes.size() == sizeof size + size);
  std::vector<T> values(size / sizeof(T));
  if (size) std::memcpy(values.data(), bytes.data() + sizeof size, size);
  return values;
}

struct Refined {
  Mesh mesh;
  HangingNodes hanging;
};
Refined refined_box(CellShape shape) {
  RefinementForest forest(box_mesh({.cells = {2, 1, 1}, .shape = shape, .removed = {}}));
  forest.refine(forest.leaf_mesh().forest_cell[0], {});
  Refined box{forest.leaf_mesh(), {}};
  box.hanging = find_hanging_nodes(forest, box.mesh);
  return box;
}

/// Three times the signed volume that VTK sees at the cell's first corner.
double orientation(const std::vector<double>& points, const std::int64_t* corners, std::array<int, 3> ends) {
  const auto at = [&](int k) { return Eigen::Map<const Eigen::Vector3d>(points.data() + 3 * corners[k]); };
  return (at(ends[0]) - at(0)).cross(at(ends[1]) - at(0)).dot(at(ends[2]) - at(0));
}

}  // namespace

TEST_CASE("base64 agrees with the examples of RFC 4648", "[vtu]") {
  const auto encoded = [](const std::string& text) { return base64(text.data(), text.size()); };
  CHECK(encoded("") == "");
  CHECK(encoded("f") == "Zg==");
  CHECK(encoded("fo") == "Zm8=");
  CHECK(encoded("foobar") == "Zm9vYmFy");
  CHECK(encoded("\xff\xfe\xfd") == "//79");
}

TEST_CASE("a grid file holds the numbers of the mesh and of its fields", "[vtu]") {
  const Refined box = refined_box(CellShape::hexahedron);
  const int nodes = box.mesh.node_count(), cells = box.mesh.cell_count();
  REQUIRE(box.hanging.hanging_count() > 0);
  VtuFields fields;
  fields.displacement = Eigen::Matrix3Xd::Random(3, nodes);
  fields.recovered_stress = Eigen::Matrix<double, 6, Eigen::Dynamic>::Random(6, nodes);
  fields.eta = Eigen::VectorXd::Random(cells);
  const std::string vtu = vtu_text(box.mesh, box.hanging, fields);

  const auto points = read_array<double>(vtu, "Points", "positions");
  const auto u = read_array<double>(vtu, "PointData", "displacement");
  const auto stress = read_array<double>(vtu, "PointData", "recovered_stress");
  const auto hanging = read_array<std::uint8_t>(vtu, "PointData", "hanging");
  const auto eta = read_array<double>(vtu, "CellData", "eta_e");
  const auto depth = read_array<std::int64_t>(vtu, "CellData", "depth");
  REQUIRE(points.size() == 3u * nodes);
  REQUIRE(hanging.size() == static_cast<std::size_t>(nodes));
  REQUIRE(stress.size() == 6u * nodes);
  REQUIRE(eta.size() == static_cast<std::size_t>(cells));
  for (int i = 0; i < nodes; ++i) {
    CHECK(hanging[i] == box.hanging.hangs(i));
    for (int k = 0; k < 3; ++k) CHECK(points[3 * i + k] == box.mesh.nodes(k, i));
    for (int k = 0; k < 3; ++k) CHECK(u[3 * i + k] == fields.displacement(k, i));
    for (int k = 0; k < 6; ++k) CHECK(stress[6 * i + k] == fields.recovered_stress(k, i));
  }
  for (int e = 0; e < cells; ++e) {
    CHECK(eta[e] == fields.eta[e]);
    CHECK(depth[e] == box.mesh.frames[e].depth);
  }
  CHECK(vtu.find("Name=\"von_mises\"", vtu.find("<CellData>")) == std::string::npos);  // was not given
}

TEST_CASE("cells have positive volume in VTK's corner order", "[vtu]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const Refined box = refined_box(shape);
  const std::string vtu = vtu_text(box.mesh, box.hanging, {});
  const auto points = read_array<double>(vtu, "Points", "positions");
  const auto connectivity = read_array<std::int64_t>(vtu, "Cells", "connectivity");
  const auto offsets = read_array<std::int64_t>(vtu, "Cells", "offsets");
  const auto types = read_array<std::uint8_t>(vtu, "Cells", "types");
  const bool hexahedra = shape == CellShape::hexahedron;
  const int corners = hexahedra ? 8 : 4;
  REQUIRE(connectivity.size() == types.size() * corners);
  for (std::size_t e = 0; e < types.size(); ++e) {
    CHECK(types[e] == (hexahedra ? 12 : 10));
    CHECK(offsets[e] == static_cast<std::int64_t>(e + 1) * corners);
    const std::int64_t* cell = connectivity.data() + e * corners;
    CHECK(orientation(points, cell, hexahedra ? std::array{1, 3, 4} : std::array{1, 2, 3}) > 0.0);
    if (!hexahedra) continue;
    // Around the bottom, then around the top: consecutive corners differ in one coordinate of a box.
    for (const int k : {0, 1, 2, 4, 5, 6}) {
      int differing = 0;
      for (int axis = 0; axis < 3; ++axis) differing += points[3 * cell[k] + axis] != points[3 * cell[k + 1] + axis];
      CHECK(differing == 1);
    }
  }
}

TEST_CASE("a curve is one poly-line through its points, where they are", "[vtu]") {
  Eigen::Matrix3Xd points(3, 4);
  points << 0, 1, 2, 3, 0, 0, 0.5, 1, -1, -1, -1, -2;
  const std::string vtu = curve_vtu_text(points);
  CHECK(vtu.find("NumberOfPoints=\"4\" NumberOfCells=\"1\"") != std::string::npos);
  CHECK(read_array<double>(vtu, "Points", "positions") == std::vector<double>(points.data(), points.data() + 12));
  CHECK(read_array<std::int64_t>(vtu, "Cells", "connectivity") == std::vector<std::int64_t>{0, 1, 2, 3});
  CHECK(read_array<std::int64_t>(vtu, "Cells", "offsets") == std::vector<std::int64_t>{4});
  CHECK(read_array<std::uint8_t>(vtu, "Cells", "types") == std::vector<std::uint8_t>{4});
}

TEST_CASE("velocities are point data when they are given, and absent when not", "[vtu]") {
  const Refined box = refined_box(CellShape::hexahedron);
  VtuFields fields;
  CHECK(vtu_text(box.mesh, box.hanging, fields).find("velocity") == std::string::npos);
  fields.velocity = Eigen::Matrix3Xd::Random(3, box.mesh.node_count());
  CHECK(read_array<double>(vtu_text(box.mesh, box.hanging, fields), "PointData", "velocity") ==
        std::vector<double>(fields.velocity.data(), fields.velocity.data() + fields.velocity.size()));
}

TEST_CASE("a new series takes the place of the old one and of nothing else", "[vtu]") {
  namespace fs = std::filesystem;
  const fs::path directory = fs::temp_directory_path() / ("finegauge_series_" + std::to_string(::getpid()));
  fs::create_directories(directory / "bar_0007.vtu.d");
  const std::vector<std::string> others = {"bar_007.vtu",       "bar_00x7.vtu", "bar_0007.vtu.old", "foobar_0007.vtu",
                                           "bar_mesh_0001.vtu", "bar.pvd",      "bar_.vtu",         "bar.json"};
  for (const std::string& name : others) std::ofstream(directory / name) << "kept";
  const std::vector<std::string> series = {vtu_series_file("bar", 0), vtu_series_file("bar", 12),
                                           vtu_series_file("bar", 12345)};
  CHECK(series == std::vector<std::string>{"bar_0000.vtu", "bar_0012.vtu", "bar_12345.vtu"});
  for (const std::string& name : series) std::ofstream(directory / name) << "old";
  remove_vtu_series(directory, "bar");
  for (const std::string& name : series) CHECK_FALSE(fs::exists(directory / name));
  for (const std::string& name : others) {
    CAPTURE(name);
    CHECK(fs::exists(directory / name));
  }
  fs::remove_all(directory);
  remove_vtu_series(directory, "bar");  // none, and no complaint
}

TEST_CASE("the share of material is a field where not all cells are full", "[vtu]") {
  Refined box = refined_box(CellShape::hexahedron);
  CHECK(vtu_text(box.mesh, box.hanging, {}).find("material_share") == std::string::npos);
  for (int cell = 0; cell < box.mesh.cell_count(); ++cell) box.mesh.fraction.push_back(1.0 / (1.0 + cell));
  CHECK(read_array<double>(vtu_text(box.mesh, box.hanging, {}), "CellData", "material_share") == box.mesh.fraction);
}

TEST_CASE("a surface file holds its triangles where they are, and what moved them", "[vtu]") {
  TriangleSurface surface;
  surface.vertices = Eigen::Matrix3Xd::NullaryExpr(3, 4, [](auto i, auto j) { return 1.0 + 10.0 * i + j; });
  surface.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Eigen::Matrix3Xd moved = 0.5 * surface.vertices;
  const std::string vtu = surface_vtu_text(surface, moved);
  CHECK(vtu.find("NumberOfPoints=\"4\" NumberOfCells=\"4\"") != std::string::npos);
  const auto values = [](const Eigen::Matrix3Xd& x) { return std::vector<double>(x.data(), x.data() + x.size()); };
  CHECK(read_array<double>(vtu, "Points", "positions") == values(surface.vertices));
  CHECK(read_array<double>(vtu, "PointData", "displacement") == values(moved));
  CHECK(read_array<std::int64_t>(vtu, "Cells", "connectivity") ==
        std::vector<std::int64_t>{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3});
  CHECK(read_array<std::int64_t>(vtu, "Cells", "offsets") == std::vector<std::int64_t>{3, 6, 9, 12});
  CHECK(read_array<std::uint8_t>(vtu, "Cells", "types") == std::vector<std::uint8_t>(4, 5));
  CHECK(surface_vtu_text(surface, Eigen::Matrix3Xd(3, 0)).find("displacement") == std::string::npos);
}
