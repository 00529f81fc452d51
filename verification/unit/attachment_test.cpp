#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/scene/attachments.hpp"
#include "core/scene/check_held.hpp"
#include "core/scene/moving_scene.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/scene_text.hpp"

using namespace finegauge;

namespace {

/// Line numbers in the tests below count these lines from one.
const std::string held_scene = R"([box]
size = [2, 1, 1]
cells = [4, 2, 2]
[material]
youngs_modulus = 1e3
poisson_ratio = 0.3
[[attachment]]
name = "back"
box_min = [0, 0, 0]
box_max = [0.5, 1, 1]
)";

const std::string moving = "[dynamics]\ntime_step = 0.01\nduration = 1\ndensity = 1000\n";

Discretization discretized(const Scene& scene) {
  const RefinementForest forest(base_mesh(scene));
  return discretize(forest, forest.leaf_mesh(), scene.material, support_conditions(scene), spring_supports(scene));
}

std::string held_message(const Scene& scene) {
  const RefinementForest forest(base_mesh(scene));
  try {
    check_held(scene, forest.topology(), discretized(scene));
  } catch (const SceneError& error) {
    return std::string(error.what()).substr(scene.file.size() + 1);
  }
  return "held";
}

double stiffness_sum(const SpringSupport& springs) {
  double sum = 0.0;
  for (const SpringPoint& point : springs.points) sum += point.stiffness;
  return sum;
}

}  // namespace

TEST_CASE("a clamped attachment is a region of the base mesh and holds it", "[scene][attachment]") {
  const Scene scene = read(held_scene, {"attachment[0].displacement=[0, 0, 0.25]"});
  const BaseMesh mesh = base_mesh(scene);
  CHECK(mesh.regions.at("back").size() == 2 * 3 * 3);
  const std::vector<SupportCondition> conditions = support_conditions(scene);
  REQUIRE(conditions.size() == 1);
  CHECK(conditions[0].surface == "back");
  CHECK_FALSE(conditions[0].course);
  const Discretization d = discretized(scene);
  REQUIRE(d.supports.reduced.size() == 18);
  for (const Eigen::Vector3d& value : d.supports.displacement) CHECK(value == Eigen::Vector3d(0, 0, 0.25));
  CHECK(d.springs.empty());
  CHECK(held_message(scene) == "held");
}

TEST_CASE("box, ball and patch select what lies in them", "[scene][attachment]") {
  struct Case {
    std::string pick;
    std::size_t nodes;
  };
  const auto [pick, nodes] = GENERATE(values<Case>({
      {"sphere_centre = [0, 0, 0]\nsphere_radius = 0.5\n", 4},
      {"patch_point = [-3, 0.25, 0.25]\npatch_radius = 0.1\n", 4},
      {"patch_point = [-3, 0.25, 0.25]\npatch_radius = 0.5\n", 11},  // two faces more beside it, two around edges
      {"box_min = [2, 0, 0]\nbox_max = [2, 1, 1]\n", 9},
  }));
  CAPTURE(pick);
  const Scene scene = read(replaced(held_scene, "box_min = [0, 0, 0]\nbox_max = [0.5, 1, 1]\n", pick));
  CHECK(base_mesh(scene).regions.at("back").size() == nodes);
}

TEST_CASE("springs carry their stiffness times the area that they hold", "[scene][attachment][springs]") {
  const std::string springs = replaced(held_scene, "box_min = [0, 0, 0]\nbox_max = [0.5, 1, 1]\n",
                                       "box_min = [0, 0, 0]\nbox_max = [0, 1, 1]\nhold = \"springs\"\nstiffness = 300\n"
                                       "displacement = [0.5, 0, 0]\n");
  for (const std::string shape : {"hexahedron", "tetrahedron"}) {
    CAPTURE(shape);
    const Scene scene = read(springs, {"box.shape=" + shape});
    CHECK(base_mesh(scene).regions.empty());
    CHECK(support_conditions(scene).empty());
    const std::vector<SpringSupport> found = spring_supports(scene);
    REQUIRE(found.size() == 1);
    CHECK(found[0].name == "back");
    CHECK_THAT(stiffness_sum(found[0]), WithinRel(300.0, 1e-14));
    CHECK(found[0].displacement(Eigen::Vector3d::Zero()) == Eigen::Vector3d(0.5, 0, 0));
    const BaseMesh mesh = base_mesh(scene);
    for (const SpringPoint& point : found[0].points) CHECK(std::abs(rest_position(mesh, point.at).x()) <= 1e-15);
    CHECK(found[0].points.size() == (shape == "hexahedron" ? 4u * 4u : 8u * 3u));
    CHECK(held_message(scene) == "held");
  }
  // One piece of the surface still holds all six motions; none at all leaves them.
  CHECK(held_message(read(springs, {"attachment[0].box_max=[0, 0.5, 0.5]"})) == "held");
  check_begins(held_message(read(replaced(held_scene, held_scene.substr(held_scene.find("[[attachment]]")), ""))),
               "1: support: the body is not held, found 0 supports that leave 6 of its six rigid motions free");
}

TEST_CASE("an attachment that leaves a motion free is refused by the line of its section", "[scene][attachment]") {
  // A single node is a ball joint.
  const Scene scene = read(held_scene, {"attachment[0].box_max=[0, 0, 0]"});
  check_begins(held_message(scene),
               "7: support: the body is not held, found 1 supports that leave 3 of its six rigid motions free");
}

TEST_CASE("attachments move by a course or by breathing", "[scene][attachment][course]") {
  const std::string still = held_scene + "displacement = [0, 0, 0.01]\n";
  const auto factor = [](const Scene& scene, double time) {
    const MotionProblem problem = motion_problem(scene);
    REQUIRE(problem.tissue.supports.size() == 1);
    REQUIRE(problem.tissue.supports[0].course);
    return problem.tissue.supports[0].course(time);
  };
  const Scene linear = read(still + "course = [[0, 0], [2, 1]]\nperiod = 4\n" + moving);
  CHECK(factor(linear, 1.0) == 0.5);
  CHECK(factor(linear, 7.0) == 0.5);
  const Scene breathing = read(still + "breathing_period = 4\nbreathing_waveform = \"cos4\"\n" + moving);
  const BreathingCourse& course = std::get<BreathingCourse>(*breathing.attachments[0].course);
  CHECK(course.waveform == BreathingWaveform::cos4);
  CHECK(course.ramp == 4.0);  // a period where the scene gives none
  CHECK(factor(breathing, 6.0) == 1.0);
  CHECK(factor(breathing, 0.0) == 0.0);
  const Scene sudden = read(still + "breathing_period = 4\nbreathing_ramp = 0\n" + moving);
  CHECK_THAT(factor(sudden, 1.0), WithinAbs(0.5, 1e-15));
  const Scene springs =
      read(still + "hold = \"springs\"\nstiffness = 2\nbreathing_period = 4\nbreathing_ramp = 2\n" + moving,
           {"attachment[0].box_max=[0.4, 1, 1]"});
  const MotionProblem problem = motion_problem(springs);
  CHECK(problem.tissue.supports.empty());
  REQUIRE(problem.tissue.springs.size() == 1);
  CHECK_THAT(stiffness_sum(problem.tissue.springs[0]), WithinRel(2.0 * (1.0 + 4 * 0.5), 1e-14));
  CHECK(problem.tissue.springs[0].course(2.0) == 1.0);
  CHECK(problem.tissue.springs[0].displacement(Eigen::Vector3d::Zero()) == Eigen::Vector3d(0, 0, 0.01));
}

TEST_CASE("an attachment outside its ranges is refused with line, field, value and range", "[scene][refusal]") {
  REQUIRE(refusal(held_scene) == "accepted");
  REQUIRE(refusal(held_scene + moving) == "accepted");
  struct Case {
    std::string from, to, message;
  };
  const auto [from, to, message] = GENERATE(values<Case>({
      {"name = \"back\"\n", "", "7: attachment[0].name: found nothing, required: a text that is not empty"},
      {"\"back\"", "\"x_min\"",
       "8: attachment[0].name: found \"x_min\", allowed a name that no other attachment and no surface has"},
      {"box_min = [0, 0, 0]\n", "", "7: attachment[0].box_min: found nothing, box_min and box_max go together"},
      {"box_max = [0.5, 1, 1]\n", "", "7: attachment[0].box_max: found nothing, box_min and box_max go together"},
      {"box_min = [0, 0, 0]\nbox_max = [0.5, 1, 1]\n", "",
       "7: attachment[0].box_min: found nothing, exactly one of box_min with box_max, sphere_centre with"},
      {"box_max = [0.5, 1, 1]", "box_max = [0.5, -1, 1]",
       "10: attachment[0].box_max[1]: found -1, allowed at least that of box_min, 0"},
      {"box_min = [0, 0, 0]", "box_min = [0, nan, 0]",
       "9: attachment[0].box_min[1]: found nan, allowed three finite numbers"},
      {"box_min = [0, 0, 0]", "box_min = [0, 0, 0]\nsphere_radius = 1",
       "10: attachment[0].sphere_radius: found beside box_min, allowed one of a box, a sphere and a patch"},
      {"box_min = [0, 0, 0]\nbox_max = [0.5, 1, 1]", "sphere_centre = [0, 0, 0]\nsphere_radius = 0",
       "10: attachment[0].sphere_radius: found 0, allowed a finite number > 0"},
      {"box_min = [0, 0, 0]\nbox_max = [0.5, 1, 1]", "sphere_centre = [0, 0, 3]\nsphere_radius = 0.5",
       "10: attachment[0].sphere_radius: found no node of the base mesh there, the nearest one is 1.5 outside of it; "
       "allowed a region with at least one"},
      {"box_min = [0, 0, 0]\nbox_max = [0.5, 1, 1]", "box_min = [3, 0, 0]\nbox_max = [4, 1, 1]",
       "10: attachment[0].box_max: found no node of the base mesh there, the nearest one is 1 outside of it"},
      {"box_min = [0, 0, 0]\nbox_max = [0.5, 1, 1]", "patch_point = [0, 0.5, 0.5]\npatch_radius = 1e-3",
       "10: attachment[0].patch_radius: found no centre of a piece of the surface there, the nearest one is 0.3525"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\nhold = \"glue\"\n",
       "11: attachment[0].hold: found \"glue\", allowed \"clamped\" or \"springs\""},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\nhold = \"springs\"\n",
       "7: attachment[0].stiffness: found nothing, needed with hold = \"springs\": a finite number > 0"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\nstiffness = 3\n",
       "11: attachment[0].stiffness: found without hold = \"springs\", allowed only with it"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\nhold = \"springs\"\nstiffness = 0\n",
       "12: attachment[0].stiffness: found 0, allowed a finite number > 0"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\ncourse = [[0, 1]]\n",
       "11: attachment[0].course: found in a static scene, allowed with [dynamics] only: a static scene has no time"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\nbreathing_period = 4\n",
       "11: attachment[0].breathing_period: found in a static scene, allowed with [dynamics] only"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\nbreathing_period = 4\n" + moving,
       "11: attachment[0].breathing_period: found without a displacement, its amplitude; allowed only with one"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\ndisplacement = [1, 0, 0]\nbreathing_ramp = 4\n" + moving,
       "12: attachment[0].breathing_ramp: found without breathing_period, allowed only with it"},
      {"box_max = [0.5, 1, 1]\n",
       "box_max = [0.5, 1, 1]\ndisplacement = [1, 0, 0]\nbreathing_waveform = \"cos4\"\n" + moving,
       "12: attachment[0].breathing_waveform: found without breathing_period, allowed only with it"},
      {"box_max = [0.5, 1, 1]\n",
       "box_max = [0.5, 1, 1]\ndisplacement = [1, 0, 0]\nbreathing_period = 4\nbreathing_waveform = \"cos6\"\n" +
           moving,
       "13: attachment[0].breathing_waveform: found \"cos6\", allowed \"sine\" or \"cos4\""},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\ndisplacement = [1, 0, 0]\nbreathing_period = 0\n" + moving,
       "12: attachment[0].breathing_period: found 0, allowed a finite number > 0"},
      {"box_max = [0.5, 1, 1]\n",
       "box_max = [0.5, 1, 1]\ndisplacement = [1, 0, 0]\nbreathing_period = 4\nbreathing_ramp = -1\n" + moving,
       "13: attachment[0].breathing_ramp: found -1, allowed a finite number >= 0"},
      {"box_max = [0.5, 1, 1]\n",
       "box_max = [0.5, 1, 1]\ndisplacement = [1, 0, 0]\nbreathing_period = 4\ncourse = [[0, 1]]\n" + moving,
       "13: attachment[0].course: found beside breathing_period, allowed one of the two"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\ncourse = [[0, 1]]\n" + moving,
       "11: attachment[0].course: found without a displacement to multiply, allowed only with one"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\ndisplacement = [1, 0, 0]\nperiod = 3\n" + moving,
       "12: attachment[0].period: found without course, allowed only with it"},
      {"box_max = [0.5, 1, 1]\n", "box_max = [0.5, 1, 1]\ngradient = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\n",
       "11: attachment[0].gradient: unknown key"},
      {"[[attachment]]", "[attachment]", "7: attachment: found a table, allowed the section [[attachment]]"},
  }));
  CAPTURE(from, to);
  check_begins(refusal(replaced(held_scene, from, to)), message);
}

TEST_CASE("two attachments of one name are refused", "[scene][refusal]") {
  const std::string second = held_scene.substr(held_scene.find("[[attachment]]"));
  check_begins(refusal(held_scene + second), "12: attachment[1].name: found \"back\", allowed a name that no other");
}
