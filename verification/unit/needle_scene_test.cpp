#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/scene/moving_scene.hpp"
#include "core/scene/scene_reader.hpp"
#include "core/scene/start_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

namespace {

/// Line numbers in the tests below count these lines from one.
const std::string needle_scene = R"([box]
size = [2, 1, 1]
cells = [2, 1, 1]
[material]
youngs_modulus = 1e3
poisson_ratio = 0.3
[[support]]
surface = "x_max"
displacement = [0, 0, 1]
course = [[0.0, 0], [2.0, 1], [3.0, 0]]
[dynamics]
time_step = 0.25
density = 1000
[needle]
youngs_modulus = 1e6
poisson_ratio = 0.3
radius = 0.01
density = 2000
base = [-1.5, 0.5, 0.5]
tip = [-0.5, 0.5, 0.5]
[[stroke]]
displacement = [1, 0, 0]
speed = 0.5
[[stroke]]
dwell = 1
[[stroke]]
displacement = [-2, 0, 0]
speed = 1
[contact]
puncture_strength = 3
cut_advance = 0.1
friction = 0.5
[adapt]
theta = 0.4
)";

/// The sections of `needle_scene` from one of these lines to the next, taken out.
std::string without(const std::string& begin, const std::string& end) {
  const std::size_t a = needle_scene.find(begin), b = end.empty() ? needle_scene.size() : needle_scene.find(end, a);
  REQUIRE(a != std::string::npos);
  REQUIRE(b != std::string::npos);
  return needle_scene.substr(0, a) + needle_scene.substr(b);
}

}  // namespace

TEST_CASE("a scene with a needle has the defaults of the table, and those of one key by another", "[scene][needle]") {
  const Scene scene = read(needle_scene);
  REQUIRE(scene.dynamics.has_value());
  REQUIRE(scene.needle.has_value());
  CHECK_FALSE(scene.adapt.has_value());  // of static scenes
  const SceneDynamics& d = *scene.dynamics;
  CHECK(d.duration == 5.0);  // 2 + 1 + 2 seconds of strokes
  CHECK(frame_count(d) == 20);
  CHECK(d.step.newton_iterations == 1);
  CHECK(d.estimate_error);
  CHECK_FALSE(d.deadline_ms.has_value());
  CHECK(d.solver.method == StepMethod::kept);
  CHECK(d.solver.linear.relative_residual == 1e-9);
  CHECK(d.solver.linear.iterations == 2000);
  REQUIRE(d.adapt.has_value());
  CHECK(d.adapt->refine_above == 0.4);
  CHECK(d.adapt->coarsen_below == 0.05);
  CHECK(d.adapt->refine_at == 0.9);
  CHECK(d.adapt->coarsen_at == 0.7);
  CHECK(d.adapt->max_depth == 1);
  CHECK(d.adapt->dwell == 10);
  const SceneNeedle& n = *scene.needle;
  CHECK(n.contact.cut_strength == 3.0);
  CHECK(n.contact.friction_in == 0.5);
  CHECK(n.contact.friction_out == 0.5);
  CHECK(n.contact.coupling_radius == 0.01);
  CHECK(n.contact.surface_friction == 0.0);
  CHECK(n.drive.guided);
  CHECK_FALSE(n.drive.base_turns);
  REQUIRE(n.drive.strokes.size() == 3);
  CHECK(n.drive.strokes[1].duration == 1.0);
  CHECK(n.drive.strokes[1].displacement == Eigen::Vector3d::Zero());
  CHECK(n.drive.strokes[2].displacement == Eigen::Vector3d(-2, 0, 0));

  const Scene other =
      read(needle_scene, {"contact.cut_strength=0", "contact.friction_out=0.1", "contact.coupling_radius=0",
                          "solver.step_method=plain", "solver.relative_residual=1e-5", "dynamics.duration=0.6",
                          "dynamics.deadline=20", "needle.base_rotation=free"});
  CHECK(other.needle->contact.cut_strength == 0.0);
  CHECK(other.needle->contact.friction_out == 0.1);
  CHECK(other.needle->contact.coupling_radius == 0.0);
  CHECK(other.needle->drive.base_turns);
  CHECK(other.dynamics->solver.method == StepMethod::plain);
  CHECK(other.dynamics->solver.linear.relative_residual == 1e-5);
  CHECK(other.dynamics->deadline_ms == 20.0);
  CHECK(frame_count(*other.dynamics) == 3);  // the last one ends after the duration
}

TEST_CASE("the problems hold what the scene says", "[scene][needle]") {
  const InsertionProblem problem =
      insertion_problem(read(needle_scene, {"dynamics.gravity=[0, 0, -9.81]", "dynamics.mass_damping=2",
                                            "load[0].body_force=[0, 3, 0]", "contact.weight=7"}));
  CHECK(problem.motion.time_step == 0.25);
  CHECK(problem.motion.tissue.density == 1000.0);
  CHECK(problem.motion.tissue.mass_damping == 2.0);
  CHECK(problem.motion.tissue.gravity == Eigen::Vector3d(0, 0, -9.81));
  CHECK(problem.motion.tissue.body(Eigen::Vector3d::Zero()) == Eigen::Vector3d(0, 3, 0));
  CHECK(problem.interaction.weight == 7.0);
  CHECK(problem.needle.element_count() == 16);
  CHECK(problem.needle.rest_positions.col(0) == Eigen::Vector3d(-1.5, 0.5, 0.5));
  CHECK((problem.needle.rest_positions.rightCols<1>() - Eigen::Vector3d(-0.5, 0.5, 0.5)).norm() < 1e-15);
  REQUIRE(problem.motion.tissue.supports.size() == 1);
  REQUIRE(problem.motion.tissue.supports[0].course);
  CHECK(problem.motion.tissue.supports[0].course(1.0) == 0.5);
}

TEST_CASE("an imperfection bends the needle at rest by the square of the distance, across its axis",
          "[scene][needle]") {
  // A direction askew to the axis: only its part across counts, at the full length of the imperfection.
  const Scene scene =
      read(needle_scene, {"needle.imperfection=0.08", "needle.imperfection_direction=[5, 0, 2]", "needle.elements=4"});
  const Eigen::Matrix3Xd nodes = scene_needle(*scene.needle).rest_positions;
  REQUIRE(nodes.cols() == 5);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d expected(-1.5 + 0.25 * i, 0.5, 0.5 + 0.08 * i * i / 16.0);
    CHECK((nodes.col(i) - expected).norm() < 1e-15);
  }
}

TEST_CASE("a scene scaled by powers of two in length, mass and time is accepted and counts the same frames",
          "[scene][needle][units]") {
  // Lengths × 2^20, as a micrometre system would have them: no check may have a length of its own.
  std::string scaled = needle_scene;
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"size = [2, 1, 1]", "size = [2097152, 1048576, 1048576]"},
           {"radius = 0.01", "radius = 10485.76"},
           {"base = [-1.5, 0.5, 0.5]", "base = [-1572864, 524288, 524288]"},
           {"tip = [-0.5, 0.5, 0.5]", "tip = [-524288, 524288, 524288]"},
           {"displacement = [1, 0, 0]\nspeed = 0.5", "displacement = [1048576, 0, 0]\nspeed = 524288"},
           {"displacement = [-2, 0, 0]\nspeed = 1", "displacement = [-2097152, 0, 0]\nspeed = 1048576"},
           {"cut_advance = 0.1", "cut_advance = 104857.6"}})
    scaled = replaced(scaled, from, to);
  REQUIRE(refusal(scaled) == "accepted");
  CHECK(frame_count(*read(scaled).dynamics) == 20);
  for (const double unit : {1e-9, 1.0, 1e9}) {
    SceneDynamics dynamics;
    dynamics.time_step = 5e-3 * unit, dynamics.duration = 2.5 * unit;
    CHECK(frame_count(dynamics) == 500);
  }
}

TEST_CASE("a needle scene outside its ranges is refused with line, field, value and range", "[scene][refusal]") {
  REQUIRE(refusal(needle_scene) == "accepted");
  struct Case {
    std::string from, to, message;
  };
  const auto [from, to, message] = GENERATE(values<Case>({
      {"radius = 0.01", "radius = 0", "17: needle.radius: found 0, allowed a finite number > 0"},
      {"radius = 0.01", "radius = -1e-3", "17: needle.radius: found -0.001, allowed a finite number > 0"},
      {"radius = 0.01", "radius = nan", "17: needle.radius: found nan, allowed a finite number > 0"},
      {"radius = 0.01\n", "", "14: needle.radius: found nothing, required: a finite number > 0"},
      {"density = 2000", "density = 0", "18: needle.density: found 0, allowed a finite number > 0"},
      {"base = [-1.5, 0.5, 0.5]", "base = [-0.5, 0.5, 0.5]",
       "20: needle.tip: found [-0.5, 0.5, 0.5], allowed a point that is not the base"},
      {"base = [-1.5, 0.5, 0.5]", "base = [nan, 0.5, 0.5]",
       "19: needle.base[0]: found nan, allowed three finite numbers"},
      {"base = [-1.5, 0.5, 0.5]", "base = [1.5, 0.5, 0.5]",
       "19: needle.base: found [1.5, 0.5, 0.5] in the body, allowed"},
      {"tip = [-0.5", "tip = [0.25", "20: needle.tip: found [0.25, 0.5, 0.5] in the body, allowed outside of the body"},
      {"tip = [-0.5", "tip = [0",
       "20: needle.tip: found [0, 0.5, 0.5] on the body's surface, allowed outside of the body, and not"},
      {"tip = [-0.5", "tip = [2.5", "20: needle.tip: found a needle that enters the body at [0, 0.5, 0.5], allowed"},
      {"displacement = [1, 0, 0]\nspeed", "displacement = [1.75, 0, 0]\nspeed",
       "19: needle.base: found a base that stroke[0] takes into the body at [0, 0.5, 0.5], allowed strokes"},
      {"tip = [-0.5, 0.5, 0.5]", "tip = [-0.5, 0.5, 0.5]\nelements = 0",
       "21: needle.elements: found 0, allowed a whole number in [1, 10000]"},
      {"tip = [-0.5, 0.5, 0.5]", "tip = [-0.5, 0.5, 0.5]\nbase_rotation = \"loose\"",
       "21: needle.base_rotation: found \"loose\", allowed \"fixed\" or \"free\""},
      {"tip = [-0.5, 0.5, 0.5]", "tip = [-0.5, 0.5, 0.5]\nimperfection = 0.1",
       "14: needle.imperfection_direction: found nothing, needed with imperfection"},
      {"tip = [-0.5, 0.5, 0.5]", "tip = [-0.5, 0.5, 0.5]\nimperfection = 0.1\nimperfection_direction = [2, 0, 0]",
       "22: needle.imperfection_direction: found a direction along the needle, allowed one across it"},
      {"tip = [-0.5, 0.5, 0.5]", "tip = [-0.5, 0.5, 0.5]\nimperfection = 1e10\nimperfection_direction = [0, 1, 0]",
       "21: needle.imperfection: found a needle that has no beams: element 0 of a chain of beams lies along the "
       "second"},
      {"friction = 0.5", "friction = -0.1", "32: contact.friction: found -0.1, allowed a finite number >= 0"},
      {"friction = 0.5", "friction = nan", "32: contact.friction: found nan, allowed a finite number >= 0"},
      {"friction = 0.5", "friction = 0.5\nfriction_out = -1",
       "33: contact.friction_out: found -1, allowed a finite number >= 0"},
      {"friction = 0.5", "friction = 0.5\nsurface_friction = -1",
       "33: contact.surface_friction: found -1, allowed a finite number >= 0"},
      {"friction = 0.5", "friction = 0.5\nclamping = -1",
       "33: contact.clamping: found -1, allowed a finite number >= 0"},
      {"friction = 0.5", "friction = 0.5\nweight = 0", "33: contact.weight: found 0, allowed a finite number > 0"},
      {"puncture_strength = 3", "puncture_strength = -3",
       "30: contact.puncture_strength: found -3, allowed a finite number >= 0"},
      {"cut_advance = 0.1", "cut_advance = 1.5",
       "31: contact.cut_advance: found 1.5, allowed at most the needle's length, 1"},
      {"cut_advance = 0.1", "cut_advance = 0", "31: contact.cut_advance: found 0, allowed a finite number > 0"},
      {"time_step = 0.25", "time_step = 0", "12: dynamics.time_step: found 0, allowed a finite number > 0"},
      {"time_step = 0.25", "time_step = nan", "12: dynamics.time_step: found nan, allowed a finite number > 0"},
      {"time_step = 0.25", "time_step = 6",
       "12: dynamics.time_step: found 6 s, allowed a duration (5 s) of at least one time step (6 s)"},
      {"time_step = 0.25", "time_step = 1e-8",
       "12: dynamics.time_step: found 500000000 frames of time_step in the duration, allowed at most 10000000"},
      {"time_step = 0.25", "time_step = 0.25\nduration = 0.1",
       "13: dynamics.duration: found 0.1 s, allowed a duration (0.1 s) of at least one time step (0.25 s)"},
      {"density = 1000\n", "density = 0\n", "13: dynamics.density: found 0, allowed a finite number > 0"},
      {"density = 1000\n", "", "11: dynamics.density: found nothing, required"},
      {"density = 1000\n", "density = 1000\nmass_damping = -1\n",
       "14: dynamics.mass_damping: found -1, allowed a finite number >= 0"},
      {"density = 1000\n", "density = 1000\nstiffness_damping = inf\n",
       "14: dynamics.stiffness_damping: found inf, allowed a finite number >= 0"},
      {"density = 1000\n", "density = 1000\nnewton_iterations = 0\n",
       "14: dynamics.newton_iterations: found 0, allowed a whole number in [1, 100]"},
      {"density = 1000\n", "density = 1000\nestimate_error = false\n",
       "14: dynamics.estimate_error: found false, allowed true with [adapt]"},
      {"density = 1000\n", "density = 1000\ndeadline = 0\n",
       "14: dynamics.deadline: found 0, allowed a finite number > 0"},
      {"speed = 0.5\n", "", "21: stroke[0].speed: found nothing, needed with displacement"},
      {"speed = 0.5", "speed = 0", "23: stroke[0].speed: found 0, allowed a finite number > 0"},
      {"displacement = [1, 0, 0]\nspeed", "displacement = [0, 0, 0]\nspeed",
       "22: stroke[0].displacement: found [0, 0, 0], allowed a motion; to rest is a dwell"},
      {"dwell = 1\n", "dwell = 1\ndisplacement = [1, 0, 0]\n",
       "26: stroke[1].displacement: found nothing, exactly one of displacement (with speed) and dwell"},
      {"dwell = 1\n", "dwell = 1\nspeed = 2\n",
       "26: stroke[1].speed: found beside dwell, allowed with displacement only"},
      {"dwell = 1\n", "dwell = -1\n", "25: stroke[1].dwell: found -1, allowed a finite number > 0"},
      {"[2.0, 1], [3.0, 0]]", "[2.0, 1], [1.0, 0]]",
       "10: support[0].course[2]: found [1, 0], allowed a list of one or more pairs [time, factor]"},
      {"[2.0, 1], [3.0, 0]]", "[2.0, 1], [2.0, 0]]", "10: support[0].course[2]: found [2, 0], allowed"},
      {"[2.0, 1], [3.0, 0]]", "[2.0, nan]]",
       "10: support[0].course[1][1]: found nan, allowed a list of one or more pairs"},
      {"[2.0, 1], [3.0, 0]]", "[2.0, 1, 3]]", "10: support[0].course[1]: found [2, 1, 3], allowed"},
      {"[3.0, 0]]", "[3.0, 0]]\nperiod = 2.5",
       "11: support[0].period: found 2.5, allowed at least the time from the first to the last point of the course, 3"},
      {"displacement = [0, 0, 1]\n", "", "9: support[0].course: found without a displacement or gradient to multiply"},
      {"course = [[0.0, 0], [2.0, 1], [3.0, 0]]", "period = 2",
       "10: support[0].period: found without course, allowed only with it"},
      {"theta = 0.4", "theta = 0.4\ncoarsen_below = 0.4",
       "35: adapt.coarsen_below: found 0.4, allowed a number below theta, 0.4, or the mesh would chatter"},
      {"theta = 0.4", "theta = 0.04",
       "34: adapt.theta: found 0.04, allowed a number above coarsen_below, 0.05, or the mesh would chatter"},
      {"theta = 0.4", "theta = 0.4\ncoarsen_below = nan",
       "35: adapt.coarsen_below: found nan, allowed a finite number in"},
      {"theta = 0.4", "theta = 0.4\ncoarsen_at = 0.9",
       "35: adapt.coarsen_at: found 0.9, allowed a number below refine_at, 0.9, or the mesh would chatter"},
      {"theta = 0.4", "theta = 0.4\nrefine_at = 0.5",
       "35: adapt.refine_at: found 0.5, allowed a number above coarsen_at, 0.7, or the mesh would chatter"},
      {"theta = 0.4", "theta = 0.4\nsteps = 3",
       "35: adapt.steps: found in a moving scene, allowed without [dynamics] only: a moving scene adapts once a frame"},
      {"theta = 0.4", "theta = 0.4\nmarking = \"bulk\"", "35: adapt.marking: found in a moving scene, allowed without"},
      {"theta = 0.4", "theta = 0.4\nthreshold = 1", "35: adapt.threshold: found in a moving scene, allowed without"},
      {"theta = 0.4", "theta = 0.4\n[solver]\nmethod = \"direct\"",
       "36: solver.method: found in a moving scene, allowed without [dynamics] only: a moving scene's choice is "
       "step_m"},
  }));
  CAPTURE(from, to);
  check_begins(refusal(replaced(needle_scene, from, to)), message);
}

TEST_CASE("sections that need one another are refused alone", "[scene][refusal]") {
  check_begins(refusal(without("[dynamics]", "[needle]")),
               "11: needle: found without [dynamics], allowed only with [dynamics] and [contact]");
  check_begins(refusal(without("[contact]", "[adapt]")), "14: needle: found without [contact], allowed only with");
  check_begins(refusal(without("[needle]", "[[stroke]]")), "22: contact: found without [needle], allowed only with it");
  check_begins(refusal(without("[needle]", "[contact]") + "[[stroke]]\ndwell = 1\n"),
               "14: contact: found without [needle], allowed only with it");
  const std::string no_needle = replaced(without("[needle]", "[adapt]"), "density", "duration = 1\ndensity");
  CHECK(refusal(no_needle) == "accepted");
  check_begins(refusal(no_needle + "[[stroke]]\ndwell = 1\n"),
               "17: stroke: found without [needle], allowed only with it");
  check_begins(refusal(without("[needle]", "[adapt]")),
               "11: dynamics.duration: found nothing, required in a moving scene without a needle");
  check_begins(refusal(without("[[stroke]]", "[contact]")),
               "11: dynamics.duration: found nothing, required in a scene without [[stroke]]");
  check_begins(refusal(no_needle + "[[quantity]]\nkind = \"tip_force\"\n"),
               "18: quantity[0].kind: found \"tip_force\" in a scene without [needle], allowed only with it");
}

TEST_CASE("keys of moving scenes are refused in static ones", "[scene][refusal]") {
  const std::string still = R"([box]
size = [2, 1, 1]
cells = [2, 1, 1]
[material]
youngs_modulus = 1e3
poisson_ratio = 0.3
[[support]]
surface = "x_min"
displacement = [1, 0, 0]
)";
  REQUIRE(refusal(still) == "accepted");
  struct Case {
    std::string added, message;
  };
  const auto [added, message] = GENERATE(values<Case>({
      {"course = [[0, 1]]\n",
       "10: support[0].course: found in a static scene, allowed with [dynamics] only: a static scene has no time"},
      {"period = 1\n", "10: support[0].period: found in a static scene, allowed with [dynamics] only"},
      {"[adapt]\nsteps = 1\ncoarsen_below = 0.1\n",
       "12: adapt.coarsen_below: found in a static scene, allowed with [dynamics] only: a static scene refines in "
       "steps"},
      {"[adapt]\nsteps = 1\ndwell = 3\n", "12: adapt.dwell: found in a static scene, allowed with [dynamics] only"},
      {"[solver]\nstep_method = \"plain\"\n",
       "11: solver.step_method: found in a static scene, allowed with [dynamics] only: a static scene's choice is "
       "method"},
      {"[[quantity]]\nkind = \"force_curve\"\n",
       "11: quantity[0].kind: found \"force_curve\" in a scene without [needle], allowed only with it"},
      {"[dynamics]\ntime_step = 1\ndensity = 0\nduration = 1\n",
       "12: dynamics.density: found 0, allowed a finite number > 0"},
  }));
  CAPTURE(added);
  check_begins(refusal(still + added), message);
}

TEST_CASE("a body that nothing holds may fly, and a needle may be pulled before it is pushed", "[scene][needle]") {
  const std::string held =
      "[[support]]\nsurface = \"x_max\"\ndisplacement = [0, 0, 1]\n"
      "course = [[0.0, 0], [2.0, 1], [3.0, 0]]\n";
  CHECK(refusal(replaced(needle_scene, held, "")) == "accepted");
  CHECK(refusal(needle_scene, {"stroke[0].displacement=[-1, 0, 0]", "stroke[2].displacement=[1.5, 0, 0]"}) ==
        "accepted");
}

TEST_CASE("the moving scenes of the reference data are read", "[scene]") {
  const Scene phantom = read_scene(reference_data() / "scenes/phantom.toml");
  CHECK(phantom.name == "phantom");
  REQUIRE(phantom.needle.has_value());
  CHECK(base_mesh(phantom).nodes.cols() == 10 * 5 * 5);
  CHECK(start_forest(phantom).leaf_count() == 144);
  CHECK((phantom.needle->tip - phantom.needle->base).norm() == Approx(0.032));
  CHECK(phantom.needle->drive.strokes.size() == 3);
  CHECK(frame_count(*phantom.dynamics) == 1140);  // 2.5 s in, 0.2 s, 3 s out, in steps of 5 ms
  CHECK(phantom.needle->contact.cut_advance == 2.0 * phantom.needle->properties.radius);
  const Scene swing = read_scene(reference_data() / "scenes/block_swing.toml");
  CHECK(swing.name == "block_swing");
  CHECK_FALSE(swing.needle.has_value());
  REQUIRE(swing.dynamics.has_value());
  CHECK(swing.dynamics->gravity == Eigen::Vector3d(0, 0, -9.81));
  CHECK(frame_count(*swing.dynamics) == 140);
}
