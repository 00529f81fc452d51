#include "core/mesh/face_patches.hpp"

#include <Eigen/Geometry>
#include <map>
#include <set>

#include "core/elasticity/cell_geometry.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

BaseMesh plain_box(std::array<int, 3> cells) {
  BoxMeshOptions options;
  options.cells = cells;
  return box_mesh(options);
}

Eigen::Vector3d place(const Mesh& mesh, const FacePatch::Side& side, double s, double t) {
  const auto N = shape_functions(CellShape::hexahedron, side.natural(s, t));
  Eigen::Vector3d X = Eigen::Vector3d::Zero();
  for (int c = 0; c < 8; ++c) X += N[c] * mesh.nodes.col(mesh.cells[side.cell][c]);
  return X;
}

}  // namespace

TEST_CASE("patches tile every face of every leaf and are at one place seen from both sides", "[face_patches]") {
  const int seed = GENERATE(1, 2, 3, 4, 5, 6);
  CAPTURE(seed);
  std::mt19937 generator(static_cast<unsigned>(seed));
  BoxMeshOptions options;
  options.cells = {2, 2, 2};
  RefinementForest forest(scrambled(distorted_box(options, 0.15, generator), generator));
  const std::vector<RefinementTemplate> templates = all_templates();
  REQUIRE(refine_randomly(forest, {templates, 12, 3, 2000}, generator) >= 3);
  const Mesh mesh = forest.leaf_mesh();
  const std::vector<FacePatch> patches = face_patches(forest.topology(), mesh);

  std::map<std::pair<int, int>, double> covered;  // cell, face
  double largest_gap = 0.0;
  std::size_t boundary = 0, split = 0;
  for (const FacePatch& patch : patches) {
    for (const FacePatch::Side& side : patch.sides) {
      if (side.cell < 0) continue;
      const double area = side.along_s.cross(side.along_t).norm();
      covered[{side.cell, side.face}] += area;
      split += area < 0.99;
      CHECK(side.natural(0.3, 0.6)[side.face / 2] == side.face % 2);  // exactly on its face
    }
    const bool outside = patch.sides[1].cell < 0;
    CHECK(outside == (patch.base.cell >= 0));
    boundary += outside;
    if (outside) continue;
    for (const auto& [s, t] : {std::pair(0.0, 0.0), {1.0, 0.0}, {0.0, 1.0}, {0.3, 0.7}})
      largest_gap =
          std::max(largest_gap, (place(mesh, patch.sides[0], s, t) - place(mesh, patch.sides[1], s, t)).norm());
  }
  CHECK(split > 50);  // faces do hang
  CHECK(boundary == mesh.boundary.size());
  CHECK(covered.size() == 6 * mesh.cells.size());
  for (const auto& [face, area] : covered) {
    CAPTURE(face.first, face.second);
    CHECK_THAT(area, WithinAbs(1.0, 1e-12));  // the sum of at most some dozens of shares
  }
  CHECK(largest_gap < 1e-13);  // round-off of places of size one
}

TEST_CASE("a face in halves against one in thirds meets in sixteen patches, the first in four of them",
          "[face_patches]") {
  RefinementForest forest(plain_box({2, 1, 1}));
  forest.refine(0, {{2, 2, 2}});
  forest.refine(1, {{3, 3, 3}});
  const Mesh mesh = forest.leaf_mesh();
  int between = 0;
  std::set<int> left, right;
  for (const FacePatch& patch : face_patches(forest.topology(), mesh)) {
    if (patch.sides[1].cell < 0) continue;
    const int base[2] = {mesh.frames[patch.sides[0].cell].base_cell, mesh.frames[patch.sides[1].cell].base_cell};
    if (base[0] == base[1]) continue;
    ++between;
    left.insert(patch.sides[base[0] == 0 ? 0 : 1].cell);
    right.insert(patch.sides[base[0] == 0 ? 1 : 0].cell);
  }
  CHECK(between == 16);
  CHECK(left.size() == 4);
  CHECK(right.size() == 9);
}

TEST_CASE("an unrefined box has one patch for each face between cells and each face outside", "[face_patches]") {
  const RefinementForest forest(plain_box({3, 4, 5}));
  const auto patches = face_patches(forest.topology(), forest.leaf_mesh());
  CHECK(patches.size() == 2 * 4 * 5 + 3 * 3 * 5 + 3 * 4 * 4 + 2 * (3 * 4 + 4 * 5 + 5 * 3));
  for (const FacePatch& patch : patches) {
    if (patch.sides[1].cell < 0) continue;
    CHECK(patch.sides[0].face % 2 == 1);  // the lower cell's upper face
    CHECK(patch.sides[1].face == patch.sides[0].face - 1);
  }
}
