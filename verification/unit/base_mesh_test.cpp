#include "core/mesh/base_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "core/elasticity/cell_geometry.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

BaseMesh notched_box(const std::array<int, 3>& cells, CellShape shape,
                     std::optional<RemovedBlock> removed = std::nullopt) {
  BoxMeshOptions options;
  options.cells = cells;
  options.size = Eigen::Vector3d(4.0, 4.0, 2.0);
  options.shape = shape;
  options.removed = removed;
  return box_mesh(options);
}

CellVectors corners(const BaseMesh& mesh, int cell) {
  CellVectors X = CellVectors::Zero();
  for (int c = 0; c < corner_count(mesh.shape); ++c) X.col(c) = mesh.nodes.col(mesh.cells[cell][c]);
  return X;
}

double volume(const BaseMesh& mesh) {
  double sum = 0.0;
  for (int cell = 0; cell < int(mesh.cells.size()); ++cell)
    sum += cell_geometry(mesh.shape, corners(mesh, cell)).volume;
  return sum;
}

/// Area of a named surface of plane faces.
double area(const BaseMesh& mesh, const std::string& name) {
  double sum = 0.0;
  for (const BaseFace& face : mesh.surfaces.at(name)) {
    const auto& local = face_corners(mesh.shape, face.face);
    const auto X = [&](int c) -> Eigen::Vector3d { return mesh.nodes.col(mesh.cells[face.cell][local[c]]); };
    sum += 0.5 * (X(1) - X(0)).cross(X(2) - X(0)).norm();
    if (mesh.shape == CellShape::hexahedron) sum += 0.5 * (X(1) - X(3)).cross(X(2) - X(3)).norm();
  }
  return sum;
}

void check_names(const std::string& problem, const std::string& what) {
  CAPTURE(problem, what);
  CHECK(problem.find(what) != std::string::npos);
}

}  // namespace

TEST_CASE("an L-shape has the nodes, cells and surfaces of an L-shape", "[base]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const BaseMesh mesh = notched_box({8, 8, 4}, shape, RemovedBlock{{4, 0, 0}, {8, 4, 4}});
  CHECK(mesh.nodes.cols() == 325);  // 975 dofs
  CHECK(mesh.cells.size() == 192 * (shape == CellShape::hexahedron ? 1 : 6));
  CHECK(validate(mesh) == "");
  CHECK_THAT(volume(mesh), WithinRel(24.0, 1e-13));
  CHECK(mesh.surfaces.size() == 7);
  for (const auto& [name, expected] : std::map<std::string, double>{{"x_min", 8.0},
                                                                    {"x_max", 4.0},
                                                                    {"y_min", 4.0},
                                                                    {"y_max", 8.0},
                                                                    {"z_min", 12.0},
                                                                    {"z_max", 12.0},
                                                                    {"notch", 8.0}}) {
    CAPTURE(name);
    CHECK_THAT(area(mesh, name), WithinRel(expected, 1e-13));
    CHECK(std::is_sorted(mesh.surfaces.at(name).begin(), mesh.surfaces.at(name).end()));
  }
  std::size_t named = 0;
  for (const auto& [name, faces] : mesh.surfaces) named += faces.size();
  CHECK(named == boundary_faces(mesh).size());
}

TEST_CASE("nodes and cells are numbered lexicographically, x fastest", "[base]") {
  const BaseMesh mesh = notched_box({4, 4, 2}, CellShape::hexahedron, RemovedBlock{{1, 1, 0}, {3, 3, 2}});
  for (int node = 1; node < mesh.nodes.cols(); ++node) {
    const Eigen::Vector3d a = mesh.nodes.col(node - 1).reverse(), b = mesh.nodes.col(node).reverse();
    CHECK(std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end()));
  }
  // The middle column of lattice nodes has no cell left.
  CHECK(mesh.nodes.cols() == 3 * 24);
  CHECK_THAT(area(mesh, "notch"), WithinRel(4 * 2.0 * 2.0, 1e-13));
  CHECK(mesh.nodes.rowwise().maxCoeff() == Eigen::Vector3d(4.0, 4.0, 2.0));  // to the last bit
}

TEST_CASE("a surface without faces has no name", "[base]") {
  const BaseMesh mesh = notched_box({4, 4, 2}, CellShape::hexahedron, RemovedBlock{{2, 0, 0}, {4, 4, 2}});
  CHECK(mesh.surfaces.count("x_max") == 0);
  CHECK_THAT(area(mesh, "notch"), WithinRel(8.0, 1e-13));
  CHECK(notched_box({1, 1, 1}, CellShape::hexahedron).surfaces.count("notch") == 0);
}

TEST_CASE("Kuhn's tetrahedra conform, fill the box and have positive volume", "[base][tetrahedron]") {
  const BaseMesh mesh = notched_box({3, 2, 4}, CellShape::tetrahedron);
  CHECK(mesh.cells.size() == 6 * 24);
  CHECK(mesh.nodes.cols() == 4 * 3 * 5);
  CHECK(validate(mesh) == "");
  CHECK_THAT(volume(mesh), WithinRel(32.0, 1e-13));
  // Two triangles per lattice face on the boundary and none inside, which a diagonal mismatch would leave.
  CHECK(boundary_faces(mesh).size() == 2 * 2 * (3 * 2 + 2 * 4 + 4 * 3));
  for (const auto& cell : mesh.cells) CHECK(std::all_of(cell.begin() + 4, cell.end(), [](int n) { return n == -1; }));
}

TEST_CASE("Kuhn's tetrahedra of a cube stay as well shaped however often they are refined", "[base][tetrahedron]") {
  BoxMeshOptions options;
  options.shape = CellShape::tetrahedron;
  RefinementForest forest(box_mesh(options));
  // Volume over the cube of the longest edge: 1/6 / 3^1.5 of a Kuhn tetrahedron.
  const double quality = 1.0 / 6.0 / std::pow(3.0, 1.5);
  for (int level = 0; level < 3; ++level) {
    const Mesh mesh = forest.leaf_mesh();
    double worst = 1.0;
    for (int cell = 0; cell < mesh.cell_count(); ++cell) {
      const CellVectors X = corner_values(mesh, cell, mesh.nodes);
      double longest = 0.0;
      for (const auto& [a, b] : tetrahedron_edges) longest = std::max(longest, (X.col(a) - X.col(b)).norm());
      worst = std::min(worst, cell_geometry(mesh.shape, X).volume / std::pow(longest, 3));
    }
    CAPTURE(level, worst / quality);
    CHECK(worst >= quality * (1.0 - 1e-12));
    for (const int cell : mesh.forest_cell) forest.refine(cell, {{2, 2, 2}});
  }
}

TEST_CASE("a tensor mesh has the coordinates that it was given", "[base]") {
  const std::array<std::vector<double>, 3> coordinates = {{{0.0, 0.1, 1.0}, {-1.0, 2.0}, {0.0, 0.5, 0.75, 1.0}}};
  const BaseMesh mesh = tensor_mesh(coordinates, std::nullopt);
  CHECK(validate(mesh) == "");
  CHECK(mesh.cells.size() == 6);
  CHECK(mesh.nodes.col(1) == Eigen::Vector3d(0.1, -1.0, 0.0));
  CHECK(mesh.nodes.col(23) == Eigen::Vector3d(1.0, 2.0, 1.0));
  CHECK_THROWS_AS(tensor_mesh({{{0.0, 1.0}, {0.0}, {0.0, 1.0}}}, std::nullopt), std::invalid_argument);
  CHECK_THROWS_AS(tensor_mesh({{{0.0, 1.0}, {0.0, 0.0}, {0.0, 1.0}}}, std::nullopt), std::invalid_argument);
}

TEST_CASE("boxes that are none are refused", "[base]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refuses = [](const BoxMeshOptions& options) { CHECK_THROWS_AS(box_mesh(options), std::invalid_argument); };
  for (const double length : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    BoxMeshOptions options;
    options.size.y() = length;
    refuses(options);
  }
  BoxMeshOptions options;
  options.cells = {1, 0, 1};
  refuses(options);
  options.cells = {100000, 100000, 100000};
  refuses(options);
  options.cells = {2, 2, 2};
  for (const RemovedBlock& block : {RemovedBlock{{0, 0, 0}, {2, 2, 2}}, RemovedBlock{{0, 0, 0}, {3, 1, 1}},
                                    RemovedBlock{{1, 1, 1}, {1, 2, 2}}, RemovedBlock{{-1, 0, 0}, {1, 1, 1}}}) {
    options.removed = block;
    refuses(options);
  }
}

TEST_CASE("unsound meshes are named by cell, node and fault", "[base][validate]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const BaseMesh sound = notched_box({2, 2, 2}, shape);
  REQUIRE(validate(sound) == "");

  BaseMesh mesh = sound;
  mesh.cells[3][2] = 27;
  check_names(validate(mesh), "cell 3: corner 2 is node 27");
  mesh.cells[3][2] = -5;
  check_names(validate(mesh), "cell 3: corner 2 is node -5");
  mesh = sound;
  mesh.cells[4][1] = mesh.cells[4][3];
  check_names(validate(mesh), "cell 4: corners 1 and 3 are both node");
  mesh = sound;
  mesh.nodes(1, 7) = std::numeric_limits<double>::quiet_NaN();
  check_names(validate(mesh), "node 7");
  mesh = sound;
  std::swap(mesh.cells[5][0], mesh.cells[5][1]);
  check_names(validate(mesh), "cell 5");
  check_names(validate(mesh), "inverted");
  mesh = sound;
  mesh.nodes.conservativeResize(3, 28);
  mesh.nodes.col(27).setZero();
  check_names(validate(mesh), "node 27 is not a corner");
  mesh = sound;
  mesh.cells.push_back(mesh.cells[0]);
  mesh.cells.push_back(mesh.cells[0]);
  check_names(validate(mesh), "share one face");
  mesh = sound;
  mesh.cells.clear();
  check_names(validate(mesh), "no cells");
}

TEST_CASE("flat cells are unsound and slender ones are not", "[base][validate]") {
  BaseMesh mesh = notched_box({1, 1, 1}, CellShape::hexahedron);
  mesh.nodes.row(2) *= 1e-8;
  CHECK(validate(mesh) == "");
  mesh.nodes.row(2) *= 0.0;
  check_names(validate(mesh), "cell 0");
  // Turned out of the axes, its Jacobian is round-off and may be positive.
  mesh = notched_box({1, 1, 1}, CellShape::hexahedron);
  mesh.nodes.row(2).setZero();
  mesh.nodes = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix() * mesh.nodes;
  check_names(validate(mesh), "cell 0");
  // Sound near corner 0 and inverted on the other side.
  mesh = notched_box({1, 1, 1}, CellShape::hexahedron);
  mesh.nodes.col(7) = Eigen::Vector3d(-0.8, -0.8, -0.4);
  check_names(validate(mesh), "cell 0");
  check_names(validate(mesh), "inverted near corner");
}

TEST_CASE("surfaces must list boundary faces, each once and in order", "[base][validate]") {
  BaseMesh mesh = notched_box({2, 1, 1}, CellShape::hexahedron);
  mesh.surfaces["inner"] = {{0, 1}};
  check_names(validate(mesh), "surface 'inner': face 1 of cell 0 is not on the boundary");
  mesh.surfaces["inner"] = {{2, 1}};
  check_names(validate(mesh), "surface 'inner': face 1 of cell 2 does not exist");
  mesh.surfaces["inner"] = {{0, 6}};
  check_names(validate(mesh), "does not exist");
  mesh.surfaces["inner"] = {{0, 0}, {0, 0}};
  check_names(validate(mesh), "listed twice");
  mesh.surfaces["inner"] = {{1, 1}, {0, 0}};
  check_names(validate(mesh), "out of order");
  mesh.surfaces["inner"] = {{0, 0}, {1, 1}};
  CHECK(validate(mesh) == "");
}
