#include "benchmarks/program/static_notes.hpp"

#include <Eigen/Geometry>
#include <numbers>

#include "benchmarks/program/certificate.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

Scene block(Kinematics kinematics) {
  Scene scene;
  BoxMeshOptions box;
  box.cells = {2, 2, 1};
  box.origin = {3.0, -2.0, 1.0};
  scene.geometry = box;
  scene.material.kinematics = kinematics;
  scene.supports.resize(1);
  scene.supports[0].surface = "x_min";
  scene.loads = {{"x_max", LoadKind::traction, {0.0, 0.0, 1e-3}}};
  return scene;
}

Discretization discretization_of(const Scene& scene) {
  return discretize(RefinementForest(base_mesh(scene)), scene.material, support_conditions(scene));
}

/// Whether one of the notes has the words; at most one may.
bool says(const std::vector<std::string>& notes, const std::string& words) {
  int found = 0;
  for (const std::string& note : notes) found += note.find(words) != std::string::npos;
  CHECK(found <= 1);
  return found == 1;
}

}  // namespace

TEST_CASE("cells that turn by more than 10 degrees are noted for linear kinematics only", "[notes]") {
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  const double degrees = GENERATE(0.0, 9.9, 10.1, 90.0, 179.0);
  CAPTURE(static_cast<int>(kinematics), degrees);
  const Scene scene = block(kinematics);
  const Discretization d = discretization_of(scene);
  const Eigen::Matrix3d Q =
      Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, Eigen::Vector3d(1.0, 2.0, -0.5).normalized())
          .toRotationMatrix();
  // A stretch is not a rotation.
  const Eigen::Matrix3d F = Q * Eigen::Vector3d(1.3, 0.8, 1.1).asDiagonal();
  const Eigen::Matrix3Xd u = F * d.mesh.nodes - d.mesh.nodes;
  CHECK_THAT(largest_cell_rotation(d, u), WithinAbs(degrees * std::numbers::pi / 180.0, 1e-7));
  CHECK(says(static_notes(scene, d, u), "linear kinematics") == (kinematics == Kinematics::linear && degrees > 10.0));
  // One cell is enough, and it is the one that turns most.
  Eigen::Matrix3Xd one = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  for (const int node : d.mesh.cells[2]) one.col(node) = u.col(node);
  CHECK(largest_cell_rotation(d, one) >= degrees * std::numbers::pi / 180.0 - 1e-7);
}

TEST_CASE("a scene in which nothing acts is noted, one with any load, force or displacement is not", "[notes]") {
  Scene scene = block(Kinematics::corotational);
  const std::string words = "nothing acts";
  const auto noted = [&] {
    const Discretization d = discretization_of(scene);
    return says(static_notes(scene, d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count())), words);
  };
  CHECK_FALSE(noted());
  const Discretization loaded = discretization_of(scene);
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, loaded.mesh.node_count());
  CHECK(says(static_notes(scene, loaded, u), "does not move"));
  u(0, 0) = 1e-300;
  CHECK_FALSE(says(static_notes(scene, loaded, u), "does not move"));
  scene.loads[0].value.setZero();
  CHECK(noted());
  scene.loads.clear();
  CHECK(noted());
  scene.body_force = {0.0, -1e-9, 0.0};
  CHECK_FALSE(noted());
  scene.body_force.setZero();
  scene.supports[0].displacement = {0.0, 0.0, 1e-12};
  CHECK_FALSE(noted());
  scene.supports[0].displacement.setZero();
  scene.supports[0].gradient(1, 2) = 0.5;
  CHECK_FALSE(noted());
  // A displacement along a direction that is not held moves nothing.
  scene.supports[0].gradient.setZero();
  scene.supports[0].components = {0};
  scene.supports[0].displacement = {0.0, 0.0, 1.0};
  CHECK(noted());
}

TEST_CASE("standard dilatation is noted from where it locks, and on tetrahedra mean dilatation too", "[notes]") {
  Scene scene = block(Kinematics::corotational);
  const bool tetrahedra = GENERATE(false, true);
  if (tetrahedra) std::get<BoxMeshOptions>(scene.geometry).shape = CellShape::tetrahedron;
  const auto noted = [&](double nu, Dilatation dilatation) {
    scene.material.poisson_ratio = nu;
    scene.material.dilatation = dilatation;
    const Discretization d = discretization_of(scene);
    return says(static_notes(scene, d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count())), "lock as");
  };
  CHECK_FALSE(noted(0.449, Dilatation::standard));
  CHECK(noted(0.45, Dilatation::standard));
  CHECK(noted(0.4999, Dilatation::standard));
  CHECK_FALSE(noted(0.449, Dilatation::mean));
  CHECK(noted(0.4999, Dilatation::mean) == tetrahedra);
}

TEST_CASE(
    "one cell through a body that bends is noted for mean dilatation, not where two share the depth, or nothing "
    "bends",
    "[notes]") {
  Scene scene = block(Kinematics::corotational);
  BoxMeshOptions& box = std::get<BoxMeshOptions>(scene.geometry);
  box.size = {4.0, 2.0, 0.5};
  box.cells = {4, 2, 1};
  scene.material.dilatation = Dilatation::mean;
  const std::string words = "reach through the body";
  const auto noted = [&](const auto& field) {
    const Discretization d = discretization_of(scene);
    Eigen::Matrix3Xd u(3, d.mesh.node_count());
    for (int node = 0; node < d.mesh.node_count(); ++node) u.col(node) = field(Eigen::Vector3d(d.mesh.nodes.col(node)));
    return says(static_notes(scene, d, u), words);
  };
  // About the middle of the depth, z = 1.25; turned by a right angle besides.
  const auto bent = [&](double curvature, double stretched) {
    return [=](const Eigen::Vector3d& X) -> Eigen::Vector3d {
      const Eigen::Vector3d x(X.x() + stretched * X.x() - curvature * (X.z() - 1.25) * X.x(), X.y(),
                              X.z() + 0.5 * curvature * X.x() * X.x());
      return Eigen::Vector3d(-x.y(), x.x(), x.z()) - X;
    };
  };
  CHECK(noted(bent(1e-3, 0.0)));
  CHECK(noted(bent(1e-3, 2e-4)));
  CHECK_FALSE(noted(bent(1e-3, 3e-3)));  // pulled more than bent
  CHECK_FALSE(noted(bent(0.0, 1e-2)));
  CHECK_FALSE(noted(bent(0.0, 0.0)));
  box.cells = {4, 2, 2};
  CHECK_FALSE(noted(bent(1e-3, 0.0)));
  box.cells = {4, 2, 1};
  scene.material.dilatation = Dilatation::standard;
  CHECK_FALSE(noted(bent(1e-3, 0.0)));
  // A beam of one cell across: its inner cells reach through along two axes, its ends along no third.
  box.cells = {4, 1, 1};
  const Discretization d = discretization_of(scene);
  CHECK(through_cells(d.mesh, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count())).through == 8);
  CHECK(through_cells(d.mesh, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count())).bent == 0);
}
