#include "benchmarks/program/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "verification/studies/estimator_kinds.hpp"
#include "verification/studies/holdout.hpp"
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
  CAPTURE(why_uncertified(scene, 0.1, true));
  const auto range = certified_range(scene, 0.1, true);
  REQUIRE(range);
  const EffectivityRange of_kind = effectivity_range(kind).value();
  CHECK_THAT(range->low, WithinAbs(0.1 / of_kind.high / 1.05, 1e-15));
  CHECK_THAT(range->high, WithinAbs(0.1 / of_kind.low * 1.05, 1e-15));
  CHECK_THAT(certificate_text(scene, 0.1, true), ContainsSubstring(rungs_of(kind)));
}

/// The lattice that a mesh is all of but for a block, from its nodes and cells alone; none where it is no such thing.
std::optional<BoxMeshOptions> as_box(const BaseMesh& mesh) {
  BoxMeshOptions box;
  box.origin = mesh.nodes.rowwise().minCoeff();
  box.size = mesh.nodes.rowwise().maxCoeff() - box.origin;
  constexpr double near = 1e-9;
  const Eigen::Vector3d cell = mesh.nodes.col(mesh.cells[0][7]) - mesh.nodes.col(mesh.cells[0][0]);
  const Eigen::Vector3d counts = box.size.cwiseQuotient(cell);
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(counts[i] - std::round(counts[i])) < near)) return {};
    box.cells[static_cast<std::size_t>(i)] = static_cast<int>(std::lround(counts[i]));
  }
  std::set<std::array<int, 3>> there;
  for (const auto& corners : mesh.cells) {
    std::array<int, 3> place{};
    for (int c = 0; c < 8; ++c) {
      const Eigen::Vector3d at = (mesh.nodes.col(corners[c]) - box.origin).cwiseQuotient(cell);
      for (int i = 0; i < 3; ++i) {
        const double step = at[i] - (c >> i & 1);
        if (!(std::abs(step - std::round(step)) < near)) return {};
        if (c == 0) place[static_cast<std::size_t>(i)] = static_cast<int>(std::lround(step));
        if (std::lround(step) != place[static_cast<std::size_t>(i)]) return {};
      }
    }
    there.insert(place);
  }
  RemovedBlock removed{box.cells, {0, 0, 0}};
  std::size_t missing = 0;
  for (int x = 0; x < box.cells[0]; ++x)
    for (int y = 0; y < box.cells[1]; ++y)
      for (int z = 0; z < box.cells[2]; ++z) {
        const std::array place = {x, y, z};
        if (there.contains(place)) continue;
        ++missing;
        for (std::size_t i = 0; i < 3; ++i) {
          removed.first[i] = std::min(removed.first[i], place[i]);
          removed.last[i] = std::max(removed.last[i], place[i] + 1);
        }
      }
  if (missing == 0) return box;
  std::size_t block = 1;
  for (std::size_t i = 0; i < 3; ++i) block *= static_cast<std::size_t>(removed.last[i] - removed.first[i]);
  if (missing != block) return {};
  box.removed = removed;
  return box;
}

/// What a user would write for a problem, as far as the certificate asks for it.
Scene scene_of(const HoldoutProblem& problem) {
  Scene scene;
  if (const auto box = as_box(problem.mesh))
    scene.geometry = *box;
  else
    scene.geometry = problem.mesh;
  scene.material = problem.problem.material;
  scene.loads = problem.problem.loads;
  const std::set<std::string> of_box = {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max", "notch"};
  const auto name = [&](const std::string& surface) {
    if (!of_box.contains(surface)) scene.surfaces.push_back({.name = surface, .nodes = {0, 1, 2, 3}});
  };
  for (const SurfaceLoad& load : scene.loads) name(load.surface);
  for (const SupportCondition& condition : problem.problem.supports) {
    name(condition.surface);
    SceneSupport support;
    support.surface = condition.surface;
    support.normal = condition.normal;
    scene.supports.push_back(support);
  }
  return scene;
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
  CHECK(rungs_of(ProblemKind::tetrahedra) != rungs_of(ProblemKind::hexahedra));
  CHECK(effectivity_range(ProblemKind::moving)->low < effectivity_range(ProblemKind::rotated)->low);
}

TEST_CASE("an estimate above those of the rungs has no range", "[certificate]") {
  const auto check_largest = [](const Scene& scene, double largest, const char* reason) {
    CHECK(certified_range(scene, largest, true));
    CHECK_FALSE(certified_range(scene, 1.01 * largest, true));
    CHECK_THAT(certificate_text(scene, 1.01 * largest, true), ContainsSubstring(reason));
  };
  for (const CellShape shape : {CellShape::hexahedron, CellShape::tetrahedron}) {
    Scene scene = box_scene();
    std::get<BoxMeshOptions>(scene.geometry).shape = shape;
    check_largest(scene, 0.5, "above 50 %");
    scene.supports.resize(2);
    scene.supports[1].gradient(0, 1) = 0.01;
    check_largest(scene, 0.3, "above 30 %");
    scene.supports[1] = SceneSupport{};
    check_largest(scene, 0.5, "above 50 %");
    scene.supports[1].displacement.x() = 1e-3;
    check_largest(scene, 0.3, "above 30 %");
  }
  Scene scene = box_scene();
  scene.material.kinematics = Kinematics::corotational;
  check_largest(scene, 0.3, "above 30 %");
  scene.material.kinematics = Kinematics::linear;
  scene.dynamics.emplace();
  check_largest(scene, 0.3, "above 30 %");
}

TEST_CASE("a scene unlike the rungs has no range, and a reason", "[certificate]") {
  const auto check_refused = [](const Scene& scene, const char* reason) {
    CHECK_FALSE(certified_range(scene, 0.1, true));
    CHECK_THAT(certificate_text(scene, 0.1, true), ContainsSubstring(reason));
  };
  Scene scene = box_scene();
  CHECK_FALSE(certified_range(scene, 0.1, false));
  CHECK(certificate_text(scene, 0.1, false) == "not certified: the solve did not converge");
  // A load on held nodes: 0 % of nothing is no certificate.
  CHECK(certificate_text(scene, 0.0, true) == "not certified: the estimate is zero, and a range is a multiple of it");
  CHECK_FALSE(certified_range(scene, 0.0, true));
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
  std::get<BoxMeshOptions>(scene.geometry).shape = CellShape::tetrahedron;
  scene.material.poisson_ratio = 0.35;
  CHECK(certified_range(scene, 0.1, true));
  scene.material.poisson_ratio = 0.36;
  check_refused(scene, "at most 0.35, above which");
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

TEST_CASE("a run of a hold-out problem prints a range where the study counts it as one that does", "[certificate]") {
  std::vector<HoldoutProblem> problems = known_holdout_problems();
  for (HoldoutProblem& drawn : drawn_holdout_problems()) problems.push_back(std::move(drawn));
  const std::map<std::string, std::string> reasons = {{refused_mesh, "is in a box"},
                                                      {refused_load, "is loaded on whole faces"},
                                                      {refused_cells, "less than twice as long as wide"},
                                                      {refused_between, "between clamped ones"}};
  std::map<std::string, int> counts;
  for (const HoldoutProblem& problem : problems) {
    CAPTURE(problem.family, problem.name, problem.refused);
    const Scene scene = scene_of(problem);
    CHECK(certified_range(scene, 0.1, true).has_value() == problem.refused.empty());
    if (!problem.refused.empty())
      CHECK_THAT(why_uncertified(scene, 0.1, true), ContainsSubstring(reasons.at(problem.refused)));
    ++counts[problem.refused];
  }
  CHECK(counts.size() == 5);  // of each reason some, and some with a range
  CHECK(counts[""] == 32);    // 28 known, 4 drawn, as the README counts
}
