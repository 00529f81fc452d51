#include "benchmarks/program/needle_sections.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/mesh/immersed_body.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/scene_reader.hpp"
#include "core/scene/start_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

namespace {

Scene phantom() {
  Scene scene = read_scene((reference_data() / "scenes" / "phantom.toml").string(), {});
  scene.dynamics->adapt.reset();
  return scene;
}

/// The frames in which each stage is drawn, "start 1, depth 7, ...", of a run that ends after `frames`.
std::string stages(const Scene& scene, const Insertion& insertion, int frames) {
  NeedleSections sections(scene);
  std::string drawn;
  for (int k = 1; k <= frames; ++k) {
    MotionFrame frame;
    frame.report.frame.frame = k;
    for (const SectionMoment& moment :
         sections.moments_of({frame, insertion.tissue, &insertion, frames, false}, k == frames))
      drawn += (drawn.empty() ? "" : ", ") + moment.stage + " " + std::to_string(k);
  }
  return drawn;
}

/// A box's surface that many of its edge inside of it on all sides.
TriangleSurface inner_box(const BoxMeshOptions& box, double inset) {
  TriangleSurface surface;
  surface.vertices.resize(3, 8);
  for (int c = 0; c < 8; ++c)
    for (int axis = 0; axis < 3; ++axis)
      surface.vertices(axis, c) = box.origin[axis] + (c >> axis & 1 ? box.size[axis] - inset : inset);
  surface.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                       {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return surface;
}

}  // namespace

TEST_CASE("a needle's run is drawn at its start, where the base has gone farthest, and at its end", "[section]") {
  Scene scene = phantom();
  const InsertionProblem problem = insertion_problem(scene);
  const Insertion insertion = start_insertion(start_forest(scene), problem);
  const double dt = scene.dynamics->time_step;
  const auto stroke = [&](double advance, int frames) { return Stroke{{advance, 0.0, 0.0}, frames * dt}; };
  scene.needle->drive.strokes = {stroke(0.02, 10), stroke(0.0, 4), stroke(-0.02, 10)};
  CHECK(stages(scene, insertion, 24) == "start 1, depth 10, end 24");
  scene.needle->drive.strokes = {stroke(0.02, 10), stroke(-0.01, 5), stroke(0.02, 8), stroke(-0.03, 5)};
  CHECK(stages(scene, insertion, 28) == "start 1, depth 23, end 28");
  scene.needle->drive.strokes = {stroke(0.02, 10), stroke(-0.02, 10), stroke(0.02, 10), stroke(-0.02, 10)};
  CHECK(stages(scene, insertion, 40) == "start 1, depth 10, end 40");  // the first of equals
  CHECK(stages(scene, insertion, 7) == "start 1, depth 7, end 7");     // ended before
  CHECK(stages(scene, insertion, 1) == "start 1, depth 1, end 1");
}

TEST_CASE("a pressed body is drawn in colours, and one at rest in one", "[section]") {
  Scene scene = phantom();
  const InsertionProblem problem = insertion_problem(scene);
  Insertion insertion = start_insertion(start_forest(scene), problem);
  const auto pictures = [&](double largest) {
    const ErrorEstimate estimate = estimate_error_spr(insertion.tissue.mesh.d, insertion.tissue.state.u);
    return section_pictures(scene, insertion, estimate, {}, {"depth", 0.0, largest});
  };
  for (const auto& [name, svg] : pictures(0.0)) {
    CHECK(svg.find("uniform: 0<") != std::string::npos);
    CHECK(svg.find("at rest") != std::string::npos);
    CHECK(svg.find("url(#body)") == std::string::npos);
  }
  for (int k = 0; k < 40; ++k) static_cast<void>(advance_frame(problem, insertion));
  const auto pressed = pictures(0.0);
  REQUIRE(pressed.size() == 2);
  CHECK(pressed[0].first == "phantom_depth_stress.svg");
  CHECK(pressed[1].first == "phantom_depth_eta.svg");
  CHECK(pressed[0].second.find("[kPa]") != std::string::npos);
  CHECK(pressed[1].second.find("[% of largest energy norm]") != std::string::npos);
  for (const auto& [name, svg] : pressed) {
    CHECK(svg.find("uniform") == std::string::npos);
    CHECK(svg.find("phantom, full depth: t = 0.2 s") != std::string::npos);
    CHECK(svg.find("class=\"needle\"") != std::string::npos);
  }
  // The same state, as what is left of a motion with 1e9 times its energy.
  const double norm = estimate_error_spr(insertion.tissue.mesh.d, insertion.tissue.state.u).energy_norm;
  for (const auto& [name, svg] : pictures(std::sqrt(1e9) * norm)) CHECK(svg.find("uniform") != std::string::npos);
}

TEST_CASE("an immersed body is drawn inside its surface only, which moves with it", "[section]") {
  const Scene scene = phantom();
  const auto& box = std::get<BoxMeshOptions>(scene.geometry);
  const TriangleSurface surface = inner_box(box, 5e-4);
  BaseMesh base = immersed_mesh(surface, {.cell_size = Eigen::Vector3d::Constant(5e-3), .origin = box.origin});
  base.surfaces["x_max"] = {boundary_faces(base).back()};  // what the scene's support holds
  const InsertionProblem problem = insertion_problem(scene);
  Insertion insertion = start_insertion(RefinementForest(base), problem);
  const std::vector<MaterialPoint> points = points_of_surface(base, surface);
  const auto outline = [&] {
    const ErrorEstimate estimate = estimate_error_spr(insertion.tissue.mesh.d, insertion.tissue.state.u);
    const std::string svg = section_pictures(scene, insertion, estimate, points, {"start", 0.0, 0.0})[0].second;
    CHECK(svg.find("<g clip-path=\"url(#body)\">") != std::string::npos);
    const std::size_t at = svg.find(" d=\"", svg.find("class=\"outline\""));
    return svg.substr(at, svg.find('>', at) - at);
  };
  const std::string at_rest = outline();
  CHECK(std::count(at_rest.begin(), at_rest.end(), 'Z') == 1);
  insertion.tissue.state.u.row(2) += 0.1 * insertion.tissue.mesh.d.mesh.nodes.row(0);  // a shear
  CHECK(outline() != at_rest);
}
