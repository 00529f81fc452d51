#include "core/space/loads.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/elasticity/cell_geometry.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

/// A box 2 × 3 × 4 m whose inner nodes are moved at will and whose nodes on a side are moved inside that side only.
BaseMesh distorted_box(CellShape shape, unsigned seed) {
  BoxMeshOptions options;
  options.cells = {2, 3, 4};
  options.size = Eigen::Vector3d(2.0, 3.0, 4.0);
  options.shape = shape;
  BaseMesh mesh = box_mesh(options);
  std::mt19937 generator(seed);
  for (int node = 0; node < mesh.nodes.cols(); ++node)
    for (int axis = 0; axis < 3; ++axis) {
      const double move = 0.1 * random_number(generator);
      if (mesh.nodes(axis, node) > 0.0 && mesh.nodes(axis, node) < options.size[axis]) mesh.nodes(axis, node) += move;
    }
  return mesh;
}

RefinementForest partly_refined(const BaseMesh& base) {
  RefinementForest forest(base);
  const bool hexahedra = base.shape == CellShape::hexahedron;
  const int first = base.surfaces.at("x_min").front().cell, last = base.surfaces.at("x_max").back().cell;
  forest.refine(first, hexahedra ? RefinementTemplate{{2, 3, 3}} : RefinementTemplate{{2, 2, 2}});
  forest.refine(last, {{2, 2, 2}});
  return forest;
}

/// Force and moment about the origin.
Eigen::Matrix<double, 6, 1> resultant(const Mesh& mesh, const Eigen::Matrix3Xd& forces) {
  Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
  for (int node = 0; node < mesh.node_count(); ++node) {
    const Eigen::Vector3d X = mesh.nodes.col(node), f = forces.col(node);
    sum.head<3>() += f;
    sum.tail<3>() += X.cross(f);
  }
  return sum;
}

Eigen::Matrix<double, 6, 1> wrench(const Eigen::Vector3d& force, const Eigen::Vector3d& at) {
  return (Eigen::Matrix<double, 6, 1>() << force, at.cross(force)).finished();
}

const Eigen::Vector3d oblique_traction(0.3, -2.0, 0.7);

}  // namespace

TEST_CASE("a traction on a plane side has its resultant, however the faces are cut", "[loads]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const bool refined = GENERATE(false, true);
  CAPTURE(int(shape), refined);
  const BaseMesh base = distorted_box(shape, 51);
  const Mesh mesh = (refined ? partly_refined(base) : RefinementForest(base)).leaf_mesh();
  REQUIRE((mesh.cell_count() > int(base.cells.size())) == refined);
  const struct {
    const char* name;
    double area;
    Eigen::Vector3d centroid;
  } sides[] = {{"x_min", 12.0, {0.0, 1.5, 2.0}},
               {"x_max", 12.0, {2.0, 1.5, 2.0}},
               {"y_max", 8.0, {1.0, 3.0, 2.0}},
               {"z_min", 6.0, {1.0, 1.5, 0.0}},
               {"z_max", 6.0, {1.0, 1.5, 4.0}}};
  for (const auto& side : sides) {
    CAPTURE(side.name);
    const Eigen::Matrix3Xd forces = nodal_loads(base, mesh, {{side.name, LoadKind::traction, oblique_traction}});
    const auto expected = wrench(side.area * oblique_traction, side.centroid);
    CHECK_THAT((resultant(mesh, forces) - expected).norm() / expected.norm(), WithinAbs(0.0, 1e-14));

    const Eigen::Matrix3Xd shared =
        nodal_loads(base, mesh, {{side.name, LoadKind::total_by_area, side.area * oblique_traction}});
    CHECK_THAT((shared - forces).norm() / forces.norm(), WithinAbs(0.0, 1e-14));
    for (int node = 0; node < mesh.node_count(); ++node) {
      bool on_side = false;
      for (int axis = 0; axis < 3; ++axis)
        on_side = on_side || (side.name[0] == "xyz"[axis] && mesh.nodes(axis, node) == side.centroid[axis]);
      // A refined tetrahedron may touch a side with an edge alone: that edge's middle hangs and has no load.
      const bool loaded = forces.col(node).norm() > 0.0;
      CHECK((shape == CellShape::hexahedron ? loaded == on_side : loaded <= on_side));
    }
  }
}

TEST_CASE("a total on a warped surface is kept whole", "[loads]") {
  BaseMesh base = distorted_box(CellShape::hexahedron, 52);
  std::mt19937 generator(53);
  for (int node = 0; node < base.nodes.cols(); ++node) base.nodes.col(node) += 0.1 * random_vector(generator);
  const Mesh mesh = partly_refined(base).leaf_mesh();
  const Eigen::Vector3d total(1.0, 2.0, 3.0);
  const Eigen::Matrix3Xd forces = nodal_loads(base, mesh, {{"z_max", LoadKind::total_by_area, total}});
  CHECK_THAT((forces.rowwise().sum() - total).norm(), WithinAbs(0.0, 1e-14));
}

TEST_CASE("the area of a warped face is that of its bilinear surface", "[loads]") {
  // One cube whose top is z = 1 + s t: area ∫∫ sqrt(1 + s² + t²), which 2×2 points meet to their order and refined
  // faces to convergence.
  BaseMesh base = box_mesh({});
  base.nodes(2, 7) += 1.0;
  double expected = 0.0;
  const int n = 1000;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      expected += std::sqrt(1.0 + std::pow((i + 0.5) / n, 2) + std::pow((j + 0.5) / n, 2)) / n / n;
  const auto area = [&](const Mesh& mesh) {
    return nodal_loads(base, mesh, {{"z_max", LoadKind::traction, {1.0, 0.0, 0.0}}}).row(0).sum();
  };
  RefinementForest forest(base);
  const double coarse = std::abs(area(forest.leaf_mesh()) - expected) / expected;
  forest.refine(0, {{4, 4, 1}});
  const double fine = std::abs(area(forest.leaf_mesh()) - expected) / expected;
  CHECK(coarse < 2e-3);
  CHECK(fine < 2e-6);  // midpoint sum: 1e-7
  CHECK(coarse > 20.0 * fine);
}

TEST_CASE("a total by node gives equal parts to all nodes of the surface", "[loads]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const BaseMesh base = distorted_box(shape, 54);
  const Mesh mesh = partly_refined(base).leaf_mesh();
  const Eigen::Vector3d total(1.0, 2.0, 3.0);
  const Eigen::Matrix3Xd forces = nodal_loads(base, mesh, {{"x_min", LoadKind::total_by_node, total}});
  int on_side = 0, loaded = 0;
  for (int node = 0; node < mesh.node_count(); ++node) {
    on_side += mesh.nodes(0, node) == 0.0;
    loaded += forces.col(node).norm() > 0.0;
  }
  CHECK(loaded > 20);  // those of the refined leaves too
  if (shape == CellShape::hexahedron) CHECK(loaded == on_side);
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (forces.col(node).norm() == 0.0) continue;
    CHECK(mesh.nodes(0, node) == 0.0);
    CHECK_THAT((forces.col(node) - total / loaded).norm(), WithinAbs(0.0, 1e-15));
  }
}

TEST_CASE("a uniform body force has the weight of the body at its centre", "[loads]") {
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const BaseMesh base = distorted_box(shape, 55);
  const Mesh mesh = partly_refined(base).leaf_mesh();
  const Eigen::Matrix3Xd forces = nodal_loads(
      base, mesh, {}, [](const Eigen::Vector3d&) { return oblique_traction; }, 3);
  const auto expected = wrench(24.0 * oblique_traction, {1.0, 1.5, 2.0});
  CHECK_THAT((resultant(mesh, forces) - expected).norm() / expected.norm(), WithinAbs(0.0, 1e-14));
}

TEST_CASE("body forces are integrated to the order of the rule", "[loads]") {
  BoxMeshOptions options;
  options.size = Eigen::Vector3d(2.0, 1.0, 1.0);
  const auto total = [&](CellShape shape, int power, int points) {
    options.shape = shape;
    const BaseMesh base = box_mesh(options);
    const Mesh mesh = RefinementForest(base).leaf_mesh();
    const auto body = [&](const Eigen::Vector3d& X) { return Eigen::Vector3d(std::pow(X.x(), power), 0.0, 0.0); };
    return nodal_loads(base, mesh, {}, body, points).row(0).sum();
  };
  const auto exact = [](int power) { return std::pow(2.0, power + 1) / (power + 1); };
  CHECK_THAT(total(CellShape::hexahedron, 3, 2), WithinRel(exact(3), 1e-14));
  CHECK_THAT(total(CellShape::hexahedron, 5, 3), WithinRel(exact(5), 1e-14));
  CHECK_THAT(total(CellShape::tetrahedron, 2, 2), WithinRel(exact(2), 1e-14));
  // An even power more is out of reach of each (odd ones may cancel by symmetry).
  CHECK(std::abs(total(CellShape::hexahedron, 4, 2) - exact(4)) > 1e-2);
  CHECK(std::abs(total(CellShape::hexahedron, 6, 3) - exact(6)) > 1e-3);
  CHECK(std::abs(total(CellShape::tetrahedron, 4, 2) - exact(4)) > 1e-3);
}

TEST_CASE("loads add up", "[loads]") {
  const BaseMesh base = distorted_box(CellShape::hexahedron, 56);
  const Mesh mesh = RefinementForest(base).leaf_mesh();
  const SurfaceLoad first{"x_max", LoadKind::traction, oblique_traction},
      second{"y_min", LoadKind::total_by_area, {0, 1, 0}};
  const Eigen::Matrix3Xd both = nodal_loads(base, mesh, {first, second});
  CHECK_THAT((both - nodal_loads(base, mesh, {first}) - nodal_loads(base, mesh, {second})).norm(),
             WithinAbs(0.0, 1e-14));
  CHECK(nodal_loads(base, mesh, {}).isZero(0.0));
}

TEST_CASE("loads that have no meaning are refused", "[loads]") {
  const BaseMesh base = distorted_box(CellShape::hexahedron, 57);
  const Mesh mesh = RefinementForest(base).leaf_mesh();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  try {
    nodal_loads(base, mesh, {{"top", LoadKind::traction, oblique_traction}});
    FAIL("a surface that does not exist was loaded");
  } catch (const std::invalid_argument& error) {
    CHECK(std::string(error.what()).find("'top'") != std::string::npos);
    CHECK(std::string(error.what()).find("z_max") != std::string::npos);
  }
  CHECK_THROWS_AS(nodal_loads(base, mesh, {{"x_max", LoadKind::traction, {0.0, nan, 0.0}}}), std::invalid_argument);
  const auto uniform = [](const Eigen::Vector3d&) { return oblique_traction; };
  CHECK_THROWS_AS(nodal_loads(base, mesh, {}, uniform, 4), std::invalid_argument);
  CHECK_THROWS_AS(nodal_loads(base, mesh, {}, [&](const Eigen::Vector3d&) { return Eigen::Vector3d(nan, 0, 0); }),
                  std::invalid_argument);
}
