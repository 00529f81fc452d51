#include "core/space/singular_edges.hpp"

#include <numbers>

#include "core/adapt/apply_refinements.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/exact_field.hpp"

using namespace finegauge;

namespace {

BaseMesh slab(std::array<int, 3> cells, const std::optional<RemovedBlock>& removed = {}) {
  BoxMeshOptions options;
  options.size = {static_cast<double>(cells[0]), static_cast<double>(cells[1]), static_cast<double>(cells[2])};
  options.cells = cells;
  options.removed = removed;
  return box_mesh(options);
}

SupportCondition clamped_at(const char* surface) { return {surface, std::nullopt, {}}; }
SupportCondition roller(const char* surface, int axis) {
  return {surface, Eigen::Vector3d(Eigen::Vector3d::Unit(axis)), {}};
}

/// The cells around the edge that each leaf touches.
std::vector<int> marks(const RefinementForest& forest, const std::vector<SupportCondition>& supports) {
  std::vector<int> cells;
  for (const SingularEdge& edge :
       singular_edges_of_cells(forest.base(), forest.topology(), forest.leaf_mesh(), supports, 0.3))
    cells.push_back(edge.cells);
  return cells;
}

/// Of a box of 3 × 3 × 1 cells, by rows of y: the marks.
std::vector<int> marks_of_plate(const std::vector<SupportCondition>& supports,
                                const std::optional<RemovedBlock>& removed = {}) {
  return marks(RefinementForest(slab({3, 3, 1}, removed)), supports);
}

}  // namespace

TEST_CASE("a free box has no singular edge, a box clamped on one face its rim", "[singular_edges]") {
  CHECK(marks_of_plate({}) == std::vector<int>(9, 0));
  // All faces of the cells at x = 0 meet free ones there, at z_min and z_max too.
  CHECK(marks_of_plate({clamped_at("x_min")}) == std::vector<int>{1, 0, 0, 1, 0, 0, 1, 0, 0});
  // Clamped all around there is no free face to meet.
  CHECK(marks_of_plate({clamped_at("x_min"), clamped_at("x_max"), clamped_at("y_min"), clamped_at("y_max"),
                        clamped_at("z_min"), clamped_at("z_max")}) == std::vector<int>(9, 0));
}

TEST_CASE("rollers at right angles to free and to clamped faces are mirrors, not edges", "[singular_edges]") {
  const std::vector<SupportCondition> plane = {roller("z_min", 2), roller("z_max", 2)};
  CHECK(marks_of_plate(plane) == std::vector<int>(9, 0));
  std::vector<SupportCondition> held = plane;
  held.push_back(clamped_at("x_min"));
  // The rim now is the two corners at which the clamped face meets the free y_min and y_max.
  CHECK(marks_of_plate(held) == std::vector<int>{1, 0, 0, 0, 0, 0, 1, 0, 0});
  // All directions held one by one are a clamp.
  std::vector<SupportCondition> one_by_one = plane;
  for (int axis = 0; axis < 3; ++axis) one_by_one.push_back(roller("x_min", axis));
  CHECK(marks_of_plate(one_by_one) == marks_of_plate(held));
  // A face held along itself only is free to bend inwards.
  CHECK(marks_of_plate({roller("x_min", 1)}) == std::vector<int>(9, 0));
}

TEST_CASE("a notch counts three cells, an edge of a support within a face two", "[singular_edges]") {
  const std::vector<int> notch = marks_of_plate({}, RemovedBlock{{2, 0, 0}, {3, 1, 1}});
  // Cells (0,0) (1,0) | (0,1) (1,1) (2,1) | (0,2) (1,2) (2,2); the notch's edge is at x = 2, y = 1.
  CHECK(notch == std::vector<int>{0, 3, 0, 3, 3, 0, 0, 0});

  BaseMesh mesh = slab({4, 1, 1});
  for (const BaseFace& face : mesh.surfaces.at("y_min"))
    if (face.cell < 2) mesh.surfaces["left_half"].push_back(face);
  RefinementForest forest(mesh);
  std::vector<SupportCondition> supports = {clamped_at("left_half"), roller("z_min", 2), roller("z_max", 2),
                                            roller("x_min", 0)};
  CHECK(marks(forest, supports) == std::vector<int>{0, 2, 2, 0});
  supports[0] = roller("left_half", 1);
  CHECK(marks(forest, supports) == std::vector<int>{0, 2, 2, 0});
}

TEST_CASE("a cell at a notch and at the rim of a clamped face counts as at the rim", "[singular_edges]") {
  // Cells (0,0) | (0,1) (1,1) (2,1) | (0,2) (1,2) (2,2); the notch's edge is at x = 1, y = 1, the clamped face at x =
  // 0.
  const RemovedBlock removed{{1, 0, 0}, {3, 1, 1}};
  CHECK(marks_of_plate({}, removed) == std::vector<int>{3, 3, 3, 0, 0, 0, 0});
  CHECK(marks_of_plate({clamped_at("x_min")}, removed) == std::vector<int>{1, 1, 3, 0, 1, 0, 0});
}

TEST_CASE("of refined cells only those that touch the edge are marked", "[singular_edges]") {
  RefinementForest forest(slab({3, 3, 1}, RemovedBlock{{2, 0, 0}, {3, 1, 1}}));
  forest.refine(3, {{2, 2, 2}});  // the cell opposite to the notch
  const Mesh mesh = forest.leaf_mesh();
  const std::vector<int> found = marks(forest, {});
  int marked = 0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    bool touches = false;
    for (const int node : mesh.cells[cell])
      touches = touches || (mesh.nodes.col(node).head<2>() - Eigen::Vector2d(2.0, 1.0)).norm() < 1e-12;
    CHECK((found[cell] != 0) == touches);
    marked += found[cell] != 0;
  }
  CHECK(marked == 4);  // two cells of the base mesh and two of eight children
}

TEST_CASE("the exponent at an edge is that of the exact fields", "[singular_edges]") {
  // The fields are made of Kolosov's potentials and fulfil the conditions on both faces point by point.
  const auto free = FaceHold::free, roller = FaceHold::roller, clamped = FaceHold::clamped;
  const double pi = std::numbers::pi, nu = GENERATE(0.1, 0.3, 0.45);
  CAPTURE(nu);
  for (const double angle : {1.1 * pi, 1.25 * pi, 1.5 * pi, 1.75 * pi, 2.0 * pi}) {
    const double exact = corner_exponent(CornerMode::opening, angle);
    CHECK_THAT(edge_exponent(free, free, angle, nu), WithinAbs(exact, 1e-9));
    CHECK_THAT(edge_exponent(free, roller, 0.5 * angle, nu), WithinAbs(exact, 1e-9));
  }
  Material material;
  material.poisson_ratio = nu;
  for (const double angle : {0.5 * pi, 2.0 * pi / 3.0}) {
    if (angle > 0.5 * pi && nu < 0.3) continue;  // complex
    double exact = 0.0;
    clamped_corner_field(angle, 0.0, {0.0, 0.0}, material, &exact);
    CHECK_THAT(edge_exponent(clamped, free, angle, nu), WithinAbs(exact, 1e-9));
  }
  CHECK(edge_exponent(free, clamped, pi, nu) == 0.5);  // complex: 1/2 ± i ln κ / 2π
  // Clamped notches are less singular than free ones: q > 1.
  CHECK(edge_exponent(clamped, clamped, 1.5 * pi, nu) > edge_exponent(free, free, 1.5 * pi, nu));
}

TEST_CASE("of two edges the one with fewer cells counts, then the sharper one", "[singular_edges]") {
  const SingularEdge rim{1, 57}, flat{2, 32}, notch{3, 34}, sharper{3, 33};
  CHECK(counts_before(rim, flat));
  CHECK(counts_before(flat, sharper));
  CHECK(counts_before(sharper, notch));
  for (const SingularEdge& edge : {rim, flat, notch, sharper}) CHECK_FALSE(counts_before(edge, edge));
}

TEST_CASE("tetrahedra that touch a singular edge with a corner are marked, with its exponent and where they lie",
          "[singular_edges]") {
  // The diagonals of the lattice run from low to high corners: a notch that is cut from the corner of large x and small
  // y leaves five tetrahedra around its edge, one from that of large x and y four.
  const bool across = GENERATE(false, true);
  BoxMeshOptions options;
  options.size = {4.0, 4.0, 2.0};
  options.cells = {4, 4, 2};
  options.shape = CellShape::tetrahedron;
  options.removed = across ? RemovedBlock{{2, 2, 0}, {4, 4, 2}} : RemovedBlock{{2, 0, 0}, {4, 2, 2}};
  RefinementForest forest(box_mesh(options));
  const auto check_marks = [&] {
    const Mesh mesh = forest.leaf_mesh();
    const std::vector<SingularEdge> found = singular_edges_of_cells(forest.base(), forest.topology(), mesh, {}, 0.3);
    int marked = 0;
    for (int cell = 0; cell < mesh.cell_count(); ++cell) {
      int there = 0, on_faces = 0;
      for (int corner = 0; corner < 4; ++corner) {
        const Eigen::Vector2d X = mesh.nodes.col(mesh.cells[cell][corner]).head<2>() - Eigen::Vector2d(2.0, 2.0);
        if (X.norm() < 1e-12)
          ++there;
        else if ((X.x() == 0.0 && (across ? X.y() > 0.0 : X.y() < 0.0)) || (X.y() == 0.0 && X.x() > 0.0))
          ++on_faces;
      }
      CHECK(static_cast<bool>(found[cell]) == (there > 0));
      CHECK(found[cell].lies_along == (there > 1));
      // Base faces that only end at the edge do not count: at an end of it a cell may have one corner there.
      CHECK((there > 0 && on_faces == 0) <= found[cell].within);
      CHECK((there == 1 ? on_faces < 2 : on_faces == 0) >= found[cell].within);
      if (there == 0) continue;
      ++marked;
      CHECK(static_cast<int>(found[cell].cells) == (across ? 2 : 3));
      CHECK_THAT(found[cell].exponent(), WithinAbs(0.54448, 1.0 / 128.0));
    }
    return marked;
  };
  const int marked = check_marks();
  CHECK(marked == 2 * (across ? 12 : 15));
  for (const int leaf : {0, 13, 30, 40}) forest.refine(leaf, {});
  check_marks();
  refine_uniformly(forest);
  check_marks();
}

TEST_CASE("at a roller before a crack tetrahedra lie within the mirrored body", "[singular_edges]") {
  BoxMeshOptions options;
  options.origin = {-2.0, 0.0, 0.0};
  options.size = {4.0, 2.0, 2.0};
  options.cells = {4, 2, 2};
  options.shape = CellShape::tetrahedron;
  BaseMesh mesh = box_mesh(options);
  for (const BaseFace& face : mesh.surfaces.at("y_min")) {
    double x = 0.0;
    for (int k = 0; k < 3; ++k) x += mesh.nodes(0, mesh.cells[face.cell][face_corners(mesh.shape, face.face)[k]]);
    if (x < 0.0) mesh.surfaces["ahead"].push_back(face);
  }
  const RefinementForest forest(std::move(mesh));
  const Mesh leaves = forest.leaf_mesh();
  const std::vector<SingularEdge> found =
      singular_edges_of_cells(forest.base(), forest.topology(), leaves, {roller("ahead", 1)}, 0.3);
  int along_within = 0;
  for (int cell = 0; cell < leaves.cell_count(); ++cell) {
    int there = 0, behind = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const Eigen::Vector3d X = leaves.nodes.col(leaves.cells[cell][corner]);
      there += X.x() == 0.0 && X.y() == 0.0;
      behind += X.x() > 0.0 && X.y() == 0.0;
    }
    CHECK(static_cast<bool>(found[cell]) == (there > 0));
    if (there < 2) continue;
    CHECK(found[cell].within == (behind == 0));
    along_within += found[cell].within;
  }
  CHECK(along_within >= 2);
}

TEST_CASE("the rim of a clamped face in tetrahedra has the corner's exponent wherever one or two of them meet there",
          "[singular_edges]") {
  BoxMeshOptions options;
  options.size = {3.0, 3.0, 3.0};
  options.cells = {3, 3, 3};
  options.shape = CellShape::tetrahedron;
  const RefinementForest forest(box_mesh(options));
  const Mesh mesh = forest.leaf_mesh();
  const std::vector<SingularEdge> found = singular_edges_of_cells(
      forest.base(), forest.topology(), mesh, {clamped_at("z_min"), roller("x_min", 0), roller("y_max", 1)}, 0.3);
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    int on_x = 0, on_y = 0;  // of the two rims that meet in a corner
    for (int corner = 0; corner < 4; ++corner) {
      const Eigen::Vector3d X = mesh.nodes.col(mesh.cells[cell][corner]);
      on_x += X.z() == 0.0 && X.x() == 3.0;
      on_y += X.z() == 0.0 && X.y() == 0.0;
    }
    const bool touches = on_x + on_y > 0;
    CHECK(static_cast<bool>(found[cell]) == touches);
    CHECK(found[cell].lies_along == (on_x > 1 || on_y > 1));
    if (!touches) continue;
    CHECK(found[cell].cells == 1);
    CHECK_THAT(found[cell].exponent(), WithinAbs(0.7112, 1.0 / 128.0));
  }
  CHECK(singular_edges_of_cells(forest.base(), forest.topology(), mesh, {roller("x_min", 0)}, 0.3) ==
        std::vector<SingularEdge>(mesh.cells.size()));
}
