#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "core/mesh/immersed_body.hpp"
#include "core/mesh/region.hpp"
#include "core/mesh/triangle_surface.hpp"
#include "core/scene/check_held.hpp"
#include "core/scene/moving_scene.hpp"
#include "core/scene/start_forest.hpp"
#include "core/tissue_frame.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/scene_text.hpp"

using namespace finegauge;

namespace {

std::string obj(const TriangleSurface& surface, const std::string& first = "") {
  std::ostringstream text;
  text.precision(17);
  text << first;
  for (Eigen::Index i = 0; i < surface.vertices.cols(); ++i)
    text << "v " << surface.vertices.col(i).transpose() << "\n";
  const int offset = static_cast<int>(std::count(first.begin(), first.end(), 'v')) + 1;
  for (const auto& t : surface.triangles)
    text << "f " << t[0] + offset << " " << t[1] + offset << " " << t[2] + offset << "\n";
  return text.str();
}

/// A sphere of radius 50 mm around the origin, in millimetres.
const TriangleSurface& sphere() {
  static const TriangleSurface surface = icosphere(8, 50.0);
  return surface;
}

/// Line numbers in the tests below count these lines from one.
std::string organ_scene(const TemporaryFile& surface) {
  return "[organ]\nsurface = \"" + surface.path().filename().string() + R"("
scale = 0.001
cell_size = 0.02
[material]
youngs_modulus = 1e4
poisson_ratio = 0.4
[[attachment]]
name = "back"
patch_point = [0, 0, -1]
patch_radius = 0.03
)";
}

const std::string moving_organ =
    "[dynamics]\ntime_step = 0.05\nduration = 4\ndensity = 1000\nstiffness_damping = 0.01\n";

}  // namespace

TEST_CASE("an organ is the surface of its file in metres, immersed, without named surfaces", "[scene][organ]") {
  const TemporaryFile file("organ.obj", obj(sphere(), "v 7 7 7\n"));
  const Scene scene = read(organ_scene(file));
  const BaseMesh mesh = base_mesh(scene);
  REQUIRE(mesh.body);
  CHECK(mesh.surfaces.empty());
  CHECK(validate(mesh).empty());
  CHECK(validate(*mesh.body, mesh).empty());
  CHECK(mesh.body->cell_size == Eigen::Vector3d::Constant(0.02));
  CHECK_THAT(enclosed_volume(mesh.body->surface), WithinRel(1e-9 * enclosed_volume(sphere()), 1e-12));
  double volume = 0.0;
  const Mesh leaves = start_forest(scene).leaf_mesh();
  for (const double share : leaves.fraction) volume += share * std::pow(0.02, 3);
  CHECK_THAT(volume, WithinRel(1e-9 * enclosed_volume(sphere()), 1e-11));
  REQUIRE(scene.notes.size() == 1);
  CHECK(scene.notes[0].find("no triangle uses") != std::string::npos);

  const BaseMesh shifted = base_mesh(read(organ_scene(file), {"organ.origin=[0.003, 0, 0]"}));
  const double cells = (shifted.body->origin.x() - 0.003) / 0.02;
  CHECK_THAT(cells, WithinAbs(std::round(cells), 1e-12));
}

TEST_CASE("an organ is held by a patch of its surface, clamped or by springs", "[scene][organ][springs]") {
  const TemporaryFile file("organ.obj", obj(sphere()));
  const bool springs = GENERATE(false, true);
  const Scene scene =
      read(organ_scene(file) + (springs ? "hold = \"springs\"\nstiffness = 1e6\n" : "displacement = [0, 0, 0.01]\n"));
  const RefinementForest forest = start_forest(scene);
  const Discretization d =
      discretize(forest, forest.leaf_mesh(), scene.material, support_conditions(scene), spring_supports(scene));
  CHECK_NOTHROW(check_held(scene, forest.topology(), d));
  if (!springs) {
    // The nodes of the cells around the patch, on both sides of the surface, and none in the body's other half.
    const std::vector<int>& region = forest.base().regions.at("back");
    CHECK(d.supports.reduced.size() == region.size());
    int inside = 0;
    for (const int node : region) {
      CHECK(forest.base().nodes(2, node) < 0.0);
      inside += contains(*forest.base().body, forest.base().nodes.col(node));
    }
    CHECK((inside > 0 && inside < int(region.size())));
    return;
  }
  // Stiffness times the area of the triangles whose centre lies within 30 mm of the pole.
  double area = 0.0;
  const TriangleSurface& surface = forest.base().body->surface;
  for (const auto& t : surface.triangles) {
    const Eigen::Vector3d a = surface.vertices.col(t[0]), b = surface.vertices.col(t[1]),
                          c = surface.vertices.col(t[2]);
    // The surface's point nearest to [0, 0, -1] is its vertex or face there, 50 mm from the middle within 0.2 mm.
    if (((a + b + c) / 3.0 - Eigen::Vector3d(0, 0, -0.05)).norm() <= 0.03) area += 0.5 * (b - a).cross(c - a).norm();
  }
  REQUIRE(d.springs.points.size() > 50);
  double stiffness = 0.0;
  for (const Springs::Point& point : d.springs.points) stiffness += point.stiffness;
  CHECK_THAT(stiffness, WithinRel(1e6 * area, 1e-12));
  CHECK(area > 0.9 * 3.14159 * 0.03 * 0.03);  // a cap of the sphere whose chord is 30 mm, less cut triangles
  CHECK(area < 1.1 * 3.14159 * 0.03 * 0.03);
}

TEST_CASE("an organ breathes: its clamped patch goes where the waveform takes it, refined or not", "[scene][organ]") {
  const TemporaryFile file("organ.obj", obj(sphere()));
  const Scene scene = read(organ_scene(file) +
                           "displacement = [0.01, 0, 0.005]\nbreathing_period = 4\nbreathing_waveform = \"cos4\"\n"
                           "breathing_ramp = 1\n[[refine]]\nmin = [-1, -1, -1]\nmax = [0, 0, 0]\n" +
                           moving_organ);
  RefinementForest forest = start_forest(scene);
  REQUIRE(forest.leaf_count() > int(forest.base().cells.size()));
  const MotionProblem problem = motion_problem(scene);
  Tissue tissue = start_tissue(std::move(forest), problem);
  EnergyLedger energy;
  double largest = 0.0;
  for (int frame = 1; frame <= 60; ++frame) {
    const FrameReport report = advance_frame(problem, tissue, energy);
    REQUIRE(report.converged);
    REQUIRE(tissue.state.u.allFinite());
    const Eigen::Vector3d expected =
        course_factor(*scene.attachments[0].course, 0.05 * frame) * scene.attachments[0].displacement;
    const BaseMesh& base = tissue.forest.base();
    for (const int node : region_nodes(base, tissue.mesh.d.mesh, base.regions.at("back")))
      REQUIRE((tissue.state.u.col(node) - expected).norm() <= 1e-15);  // round-off of 1 cm
    largest = std::max(largest, expected.norm());
  }
  CHECK_THAT(largest, WithinAbs(std::hypot(0.01, 0.005), 1e-6));  // at inhale, frame 40
}

TEST_CASE("what an organ does not have is refused with the reason", "[scene][organ][refusal]") {
  const TemporaryFile file("organ.obj", obj(sphere()));
  const std::string scene = organ_scene(file);
  REQUIRE(refusal(scene) == "accepted");
  struct Case {
    std::string from, to, message;
  };
  const auto [from, to, message] = GENERATE(values<Case>({
      {"[[attachment]]", "[[support]]\nsurface = \"z_min\"\n[[attachment]]",
       "9: support[0].surface: found \"z_min\" in a scene with [organ], which has none: the faces of its cells are not "
       "the body's surface; allowed [[attachment]], which holds or moves a part of it"},
      {"[[attachment]]", "[[load]]\nsurface = \"boundary\"\ntraction = [0, 0, 1]\n[[attachment]]",
       "9: load[0].surface: found \"boundary\" in a scene with [organ], which has none"},
      {"[[attachment]]", "[[surface]]\nname = \"top\"\nnormal = [0, 0, 1]\npoint = [0, 0, 0.05]\n[[attachment]]",
       "9: surface[0].name: found \"top\" in a scene with [organ], whose cells' faces are not the body's surface"},
      {"[material]", "[box]\nsize = [1, 1, 1]\ncells = [1, 1, 1]\n[material]",
       "1: organ: found beside [box], allowed exactly one of [box], [mesh], [gmsh], [organ]"},
      {"scale = 0.001", "scale = 0", "3: organ.scale: found 0, allowed a finite number > 0"},
      {"cell_size = 0.02", "cell_size = -0.02", "4: organ.cell_size: found -0.02, allowed a finite number > 0"},
      {"cell_size = 0.02", "cell_size = 1e-5", "4: organ.cell_size: found no lattice for the surface: cell size: the"},
      {"cell_size = 0.02\n", "cell_size = 0.02\norigin = [0, 3e4, 0]\n",
       "5: organ.origin: found a corner far from the surface, allowed one within a million cells of it"},
      {"cell_size = 0.02\n", "cell_size = 0.02\norigin = [1e60, 0, 0]\n", "5: organ.origin: found a corner far"},
      {"cell_size = 0.02\n", "", "1: organ.cell_size: found nothing, required: a finite number > 0"},
      {"surface = \"", "surface = \"not_there_", "2: organ.surface: found no file \""},
      {"patch_radius = 0.03", "patch_radius = 1e-4",
       "11: attachment[0].patch_radius: found no centre of a piece of the surface there, the nearest one is 0.00"},
      {"patch_point = [0, 0, -1]\npatch_radius = 0.03", "box_min = [1, 1, 1]\nbox_max = [2, 2, 2]",
       "11: attachment[0].box_max: found no node of the base mesh there, the nearest one is 1."},
      {"patch_point", "patch_pont", "10: attachment[0].patch_pont: unknown key, the nearest known one is \"patch_p"},
  }));
  CAPTURE(from, to);
  check_begins(refusal(replaced(scene, from, to)), message);
}

TEST_CASE("an organ so far from zero that its lattice is lost in rounding is refused", "[scene][organ][refusal]") {
  // 128 mm wide at 1e17 mm, where doubles are 16 mm apart; in metres the distance is 1e14 and they are 16 mm apart
  // again.
  const TemporaryFile file("organ.obj", obj(closed_box({128, 128, 128}, {1e17, 0, 0})));
  const std::string message = refusal(replaced(organ_scene(file), "cell_size = 0.02", "cell_size = 0.005"));
  check_begins(message, "4: organ.cell_size: found no lattice for the surface: cell 0 around (1e+14, ");
}

TEST_CASE("a broken surface is refused by its own file and place", "[scene][organ][refusal]") {
  TriangleSurface broken = sphere();
  broken.triangles.pop_back();
  const TemporaryFile file("organ.obj", obj(broken));
  const std::string message = refusal(organ_scene(file));
  CHECK(message.find(file.path().string() + ": surface: found ") == 0);
  CHECK(message.find("edge") != std::string::npos);
}
