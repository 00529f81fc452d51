#include "benchmarks/program/certificate.hpp"

#include "verification/studies/estimator_kinds.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

Scene box_scene() {
  Scene scene;
  BoxMeshOptions box;
  box.cells = {4, 4, 4};
  scene.geometry = box;
  scene.loads = {{"x_max", LoadKind::traction, Eigen::Vector3d::UnitX()}};
  return scene;
}

SceneSupport clamped_at(const char* face) {
  SceneSupport support;
  support.surface = face;
  return support;
}

/// The range is that of the kind's rungs and a twentieth.
void check_range(const Scene& scene, ProblemKind kind) {
  CAPTURE(why_uncertified(scene));
  const auto range = certified_range(scene, 0.1, true);
  REQUIRE(range);
  const EffectivityRange of_kind = effectivity_range(kind).value();
  CHECK_THAT(range->low, WithinAbs(0.1 / of_kind.high / 1.05, 1e-15));
  CHECK_THAT(range->high, WithinAbs(0.1 / of_kind.low * 1.05, 1e-15));
  CHECK_THAT(certificate_text(scene, 0.1, true), ContainsSubstring(rungs_of(kind)));
}

}  // namespace

TEST_CASE("each kind of scene has the range of its own rungs", "[certificate]") {
  Scene scene = box_scene();
  check_range(scene, ProblemKind::hexahedra);
  std::get<BoxMeshOptions>(scene.geometry).shape = CellShape::tetrahedron;
  check_range(scene, ProblemKind::tetrahedra);
  scene = box_scene();
  scene.material.kinematics = Kinematics::corotational;
  check_range(scene, ProblemKind::rotated);
  scene.dynamics.emplace();
  check_range(scene, ProblemKind::moving);
  // The kinds do differ, or this shows nothing.
  CHECK(effectivity_range(ProblemKind::tetrahedra)->low < effectivity_range(ProblemKind::moving)->low);
  CHECK(effectivity_range(ProblemKind::moving)->low < effectivity_range(ProblemKind::rotated)->low);
}

TEST_CASE("a scene unlike the rungs has no range, and a reason", "[certificate]") {
  const auto check_refused = [](const Scene& scene, const char* reason) {
    CHECK_FALSE(certified_range(scene, 0.1, true));
    CHECK_THAT(certificate_text(scene, 0.1, true), ContainsSubstring(reason));
  };
  Scene scene = box_scene();
  CHECK_FALSE(certified_range(scene, 0.1, false));
  CHECK(certificate_text(scene, 0.1, false) == "not certified: the solve did not converge");
  scene.estimator = Estimator::spr;
  check_refused(scene, "the plain estimator");
  scene = box_scene();
  scene.needle.emplace();
  check_refused(scene, "no finite energy");
  scene = box_scene();
  scene.material.poisson_ratio = 0.46;
  check_refused(scene, "at most 0.45");
  scene.material.dilatation = Dilatation::mean;
  CHECK(certified_range(scene, 0.1, true));
  scene = box_scene();
  std::get<BoxMeshOptions>(scene.geometry).cells = {4, 4, 1};
  check_refused(scene, "two cells or more");
  scene = box_scene();
  std::get<BoxMeshOptions>(scene.geometry).shape = CellShape::tetrahedron;
  scene.dynamics.emplace();
  check_refused(scene, "has hexahedra");
  scene = box_scene();
  scene.attachments.emplace_back();
  check_refused(scene, "is held on surfaces");
  scene = box_scene();
  scene.loads[0].kind = LoadKind::total_by_node;
  check_refused(scene, "is loaded by tractions");
  scene = box_scene();
  scene.surfaces.push_back({.name = "patch", .nodes = {0, 1, 5, 6}});
  CHECK(certified_range(scene, 0.1, true));  // named, not loaded
  scene.loads[0].surface = "patch";
  check_refused(scene, "on whole faces");
  scene.surfaces[0].normal = Eigen::Vector3d::UnitX();
  CHECK(certified_range(scene, 0.1, true));  // a plane ends where the body does
  // Cells of 1:2 across a rim or a notch, not along it.
  scene = box_scene();
  scene.supports = {clamped_at("x_min")};
  std::get<BoxMeshOptions>(scene.geometry).cells = {8, 4, 4};
  check_refused(scene, "less than twice as long as wide");
  std::get<BoxMeshOptions>(scene.geometry).cells = {4, 4, 8};
  check_refused(scene, "less than twice as long as wide");
  std::get<BoxMeshOptions>(scene.geometry).cells = {7, 4, 4};
  CHECK(certified_range(scene, 0.1, true));
  scene.supports[0].components = {0};
  std::get<BoxMeshOptions>(scene.geometry).cells = {8, 4, 4};
  CHECK(certified_range(scene, 0.1, true));  // on rollers
  std::get<BoxMeshOptions>(scene.geometry).removed = RemovedBlock{{4, 2, 0}, {8, 4, 4}};
  check_refused(scene, "less than twice as long as wide");
  std::get<BoxMeshOptions>(scene.geometry).cells = {4, 4, 8};
  std::get<BoxMeshOptions>(scene.geometry).removed = RemovedBlock{{2, 2, 0}, {4, 4, 8}};
  CHECK(certified_range(scene, 0.1, true));  // the notch runs along z
  scene = box_scene();
  scene.supports = {clamped_at("y_min"), clamped_at("y_max")};
  check_refused(scene, "between clamped ones");
  scene.loads[0].surface = "y_max";
  CHECK(certified_range(scene, 0.1, true));
  scene = box_scene();
  scene.geometry = box_mesh(BoxMeshOptions{});
  check_refused(scene, "is in a box");
}
