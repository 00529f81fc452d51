#include "core/space/free_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/adapt/apply_refinements.hpp"
#include "core/adapt/stress_recovery.hpp"
#include "core/mesh/base_mesh.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

BoxMeshOptions unit_cube(CellShape shape) {
  BoxMeshOptions options;
  options.cells = {3, 3, 3};
  options.shape = shape;
  return options;
}

const std::vector<SupportCondition> clamped_below = {{"z_min", std::nullopt, {}}};
const std::vector<SurfaceLoad> pulled_above = {{"z_max", LoadKind::traction, {0.0, 0.0, 1.0}}};

/// What a face x = 0 or 1 and one y = 0 or 1 that meet, or not, leave of the directions.
Eigen::Matrix3d directions_beside(const Eigen::Vector3d& X, bool x_is_free = true) {
  Eigen::Matrix3d P = Eigen::Matrix3d::Identity();
  if (x_is_free && (X.x() == 0.0 || X.x() == 1.0)) P(0, 0) = 0.0;
  if (X.y() == 0.0 || X.y() == 1.0) P(1, 1) = 0.0;
  return P;
}

}  // namespace

TEST_CASE("nodes beside supports and loads have no traction, and those on edges none on either face",
          "[free_surface]") {
  RefinementForest forest(box_mesh(unit_cube(CellShape::tetrahedron)));
  refine_uniformly(forest);
  const Mesh uniform = forest.leaf_mesh();
  for (const int cell : {0, 100, 700}) forest.refine(uniform.forest_cell[cell], {});
  Discretization d = discretize(forest, {}, clamped_below);
  d.free_surface = find_free_surface(forest, d, clamped_below, pulled_above);
  const FreeSurface& surface = d.free_surface;
  int free_nodes = 0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const Eigen::Vector3d X = d.mesh.nodes.col(node);
    const bool side = X.x() == 0.0 || X.x() == 1.0 || X.y() == 0.0 || X.y() == 1.0;
    const bool expected = side && X.z() > 0.0 && X.z() < 1.0 && !d.hanging.hangs(node);
    CHECK(std::ranges::binary_search(surface.nodes, node) == expected);
    free_nodes += expected;
  }
  REQUIRE(free_nodes > 24);
  // In linear kinematics the surface stays where it is.
  const auto directions = free_directions(d, Eigen::Matrix3Xd::Random(3, d.mesh.node_count()));
  for (std::size_t k = 0; k < surface.nodes.size(); ++k)
    CHECK((directions[k] - directions_beside(d.mesh.nodes.col(surface.nodes[k]))).norm() < 1e-12);
}

TEST_CASE("a roller says nothing of the traction on the free face beside it", "[free_surface]") {
  const RefinementForest forest(box_mesh(unit_cube(CellShape::tetrahedron)));
  std::vector<SupportCondition> supports = clamped_below;
  supports.push_back({"x_min", Eigen::Vector3d(Eigen::Vector3d::UnitX()), {}});
  supports.push_back({"x_max", Eigen::Vector3d(Eigen::Vector3d::UnitX()), {}});
  Discretization d = discretize(forest, {}, supports);
  d.free_surface = find_free_surface(forest, d, supports, pulled_above);
  const FreeSurface& surface = d.free_surface;
  const auto directions = free_directions(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
  CHECK(surface.nodes.size() == 2 * 2 * 4);  // y = 0 and 1, two rows of four between the ends
  for (std::size_t k = 0; k < surface.nodes.size(); ++k)
    CHECK((directions[k] - directions_beside(d.mesh.nodes.col(surface.nodes[k]), false)).norm() < 1e-12);
}

TEST_CASE("the edge of a notch is no free surface, nor is anything of hexahedra or where springs pull",
          "[free_surface]") {
  BoxMeshOptions options = unit_cube(CellShape::tetrahedron);
  options.cells = {4, 4, 2};
  options.removed = RemovedBlock{{2, 0, 0}, {4, 2, 2}};
  const RefinementForest notched(box_mesh(options));
  const Discretization d = discretize(notched, {}, {});
  const FreeSurface surface = find_free_surface(notched, d, {}, {});
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const bool on_edge = d.mesh.nodes(0, node) == 0.5 && d.mesh.nodes(1, node) == 0.5;
    CHECK(std::ranges::binary_search(surface.nodes, node) == (d.mesh.on_boundary[node] && !on_edge));
  }

  const RefinementForest hexahedra(box_mesh(unit_cube(CellShape::hexahedron)));
  CHECK(find_free_surface(hexahedra, discretize(hexahedra, {}, {}), {}, {}).nodes.empty());
  SpringSupport spring;
  spring.name = "spring";
  spring.points.push_back({{0, Eigen::Vector3d::Constant(0.25)}, 1.0});
  const Discretization held = discretize(notched, notched.leaf_mesh(), {}, {}, {spring});
  CHECK(find_free_surface(notched, held, {}, {}).nodes.empty());
}

TEST_CASE("a region that is held along the surface is not free", "[free_surface]") {
  BaseMesh mesh = box_mesh(unit_cube(CellShape::tetrahedron));
  for (int node = 0; node < mesh.nodes.cols(); ++node)
    if (mesh.nodes(1, node) == 0.0 && mesh.nodes(2, node) > 0.5) mesh.regions["held"].push_back(node);
  const RefinementForest forest(std::move(mesh));
  std::vector<SupportCondition> supports = clamped_below;
  supports.push_back({"held", Eigen::Vector3d(Eigen::Vector3d::UnitX()), {}});
  const Discretization d = discretize(forest, {}, supports);
  for (const int node : find_free_surface(forest, d, supports, {}).nodes)
    CHECK_FALSE((d.mesh.nodes(1, node) == 0.0 && d.mesh.nodes(2, node) > 0.5));
}

TEST_CASE("facets of a curved face count as one, a face that folds as two, and directions turn with the body",
          "[free_surface]") {
  const RefinementForest forest(box_mesh(unit_cube(CellShape::tetrahedron)));
  Material material;
  material.kinematics = Kinematics::corotational;
  Discretization d = discretize(forest, material, clamped_below);
  d.free_surface = find_free_surface(forest, d, clamped_below, pulled_above);
  const FreeSurface& surface = d.free_surface;
  const Eigen::Matrix3Xd& X = d.mesh.nodes;
  // The face y = 0 bent along x = 1/3 by an angle.
  const auto rank_where_bent = [&](double degrees) {
    Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, X.cols());
    const double slope = std::tan(degrees * std::acos(-1.0) / 180.0);
    for (Eigen::Index node = 0; node < X.cols(); ++node) u(1, node) = slope * std::max(0.0, X(0, node) - 1.0 / 3.0);
    const auto directions = free_directions(d, u);
    for (std::size_t k = 0; k < directions.size(); ++k)
      if (const auto at = X.col(surface.nodes[k]); at.y() == 0.0 && std::abs(at.x() - 1.0 / 3.0) < 1e-12)
        return directions[k].trace();
    return 0.0;
  };
  CHECK_THAT(rank_where_bent(25.0), Catch::Matchers::WithinAbs(2.0, 1e-12));
  CHECK_THAT(rank_where_bent(50.0), Catch::Matchers::WithinAbs(1.0, 1e-12));

  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.0, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  const auto before = free_directions(d, Eigen::Matrix3Xd::Zero(3, X.cols())), after = free_directions(d, R * X - X);
  for (std::size_t k = 0; k < before.size(); ++k) CHECK((after[k] - R * before[k] * R.transpose()).norm() < 1e-12);

  // However long and fine the cells are on one side of a right angle, there are two faces.
  const Eigen::Vector3d stretch(1.0, 30.0, 0.1);
  const auto stretched = free_directions(d, stretch.asDiagonal() * X - X);
  for (std::size_t k = 0; k < before.size(); ++k) CHECK((stretched[k] - before[k]).norm() < 1e-12);
}

TEST_CASE("the twice recovered stress has no traction on the free surface, and keeps a stress that has none",
          "[free_surface]") {
  const RefinementForest forest(box_mesh(unit_cube(CellShape::tetrahedron)));
  for (const Kinematics kinematics : {Kinematics::linear, Kinematics::corotational}) {
    Material material;
    material.kinematics = kinematics;
    Discretization d = discretize(forest, material, clamped_below);
    d.free_surface = find_free_surface(forest, d, clamped_below, pulled_above);
    // Small, so that lengths along the bar are the same in both kinematics but for round-off, then turned.
    const double strain = 1e-7;
    Eigen::Matrix3Xd u = strain * Eigen::Vector3d(-0.3, -0.3, 1.0).asDiagonal() * d.mesh.nodes;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    if (kinematics == Kinematics::corotational) {
      R = Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitX()).toRotationMatrix();
      u = (R * (d.mesh.nodes + u) - d.mesh.nodes).eval();
    }
    const double pull = strain * material.youngs_modulus;
    const CellStresses stresses = cell_stresses(d, u);
    const auto directions = free_directions(d, u);
    const VoigtColumns kept = recover_stress_twice(d, stresses, directions);
    const Voigt expected = voigt(pull * R.col(2) * R.col(2).transpose());
    for (int node = 0; node < d.mesh.node_count(); ++node) CHECK((kept.col(node) - expected).norm() < 1e-5 * pull);

    CellStresses sheared = stresses;
    sheared.centre.colwise() += Voigt::Constant(pull);
    const VoigtColumns recovered = recover_stress_twice(d, sheared, directions);
    for (std::size_t k = 0; k < d.free_surface.nodes.size(); ++k) {
      const Eigen::Matrix3d sigma = stress_tensor(recovered.col(d.free_surface.nodes[k]));
      CHECK((sigma * (Eigen::Matrix3d::Identity() - directions[k])).norm() < 1e-12 * pull);
    }
    CHECK((recover_stress_spr(d, sheared).colwise() - (expected + Voigt::Constant(pull))).norm() < 1e-4 * pull);
  }
}
