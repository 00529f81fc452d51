#include "core/scene/scene_reader.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <vector>

#include "core/mesh/refinement_forest.hpp"
#include "core/scene/check_held.hpp"
#include "core/scene/scene_keys.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

namespace {

/// Line numbers in the tests below count these lines from one.
const std::string small_scene = R"([box]
size = [2, 1, 1]
cells = [2, 1, 1]
[material]
youngs_modulus = 1e3
poisson_ratio = 0.3
[[support]]
surface = "x_min"
[[load]]
surface = "x_max"
traction = [1, 0, 0]
)";

const std::string small_mesh = R"([mesh]
nodes = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0],
         [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
cells = [
  [0, 1, 2, 3, 4, 5, 6, 7],
]
[material]
youngs_modulus = 1e3
poisson_ratio = 0.3
)";

void check_base_held(const Scene& scene) {
  const RefinementForest forest(base_mesh(scene));
  check_held(scene, forest.topology(), discretize(forest, scene.material, support_conditions(scene)));
}

}  // namespace

TEST_CASE("every static scene of the reference data is read, and its body is held", "[scene]") {
  struct Case {
    std::string name;
    std::size_t cells;
  };
  const auto [name, cells] = GENERATE(values<Case>({{"lshape", 192},
                                                    {"patch_test", 7},
                                                    {"block_tetrahedra", 162},
                                                    {"incompressible_block", 256},
                                                    {"cantilever_corotational", 80},
                                                    {"gmsh_block", 16}}));
  CAPTURE(name);
  const Scene scene = read_scene(reference_data() / "scenes" / (name + ".toml"));
  CHECK(scene.name == name);
  CHECK_FALSE(scene.description.empty());
  CHECK(base_mesh(scene).cells.size() == cells);
  CHECK_NOTHROW(check_base_held(scene));
}

TEST_CASE("the scene of the L-shape says what the study needs", "[scene]") {
  const Scene scene = read_scene(reference_data() / "scenes/lshape.toml");
  const BaseMesh mesh = base_mesh(scene);
  CHECK(mesh.nodes.cols() == 325);  // 975 degrees of freedom
  CHECK(mesh.surfaces.at("notch").size() == 32);
  CHECK(scene.dimensionless);
  CHECK(scene.material.youngs_modulus == 1e3);
  CHECK(scene.material.dilatation == Dilatation::standard);
  const std::vector<SupportCondition> supports = support_conditions(scene);
  REQUIRE(supports.size() == 2);
  CHECK(supports[0].surface == "x_max");
  CHECK_FALSE(supports[0].normal.has_value());
  CHECK(supports[1].surface == "y_max");
  CHECK(supports[1].normal == Eigen::Vector3d(0, 1, 0));
  REQUIRE(scene.loads.size() == 1);
  CHECK(scene.loads[0].surface == "x_min");
  CHECK(scene.loads[0].kind == LoadKind::traction);
  CHECK(scene.loads[0].value == Eigen::Vector3d(-1, 0, 0));
  CHECK_FALSE(body_force(scene));
  REQUIRE(scene.adapt.has_value());
  CHECK(scene.adapt->marking == Marking::maximum);
  CHECK(scene.adapt->theta == 0.3);
  CHECK(scene.adapt->policy == RefinementPolicy::one_template);
  REQUIRE(scene.quantities.size() == 1);
  CHECK(scene.quantities[0].kind == QuantityKind::energy);
}

TEST_CASE("the help names every key with its range, and its example is a scene", "[scene][help]") {
  const std::string help = scene_help();
  for (const SceneKey& key : scene_keys()) {
    CAPTURE(key.section, key.key);
    CHECK(find_section(key.section) != nullptr);
    CHECK_FALSE(key.explanation.empty());
    CHECK(help.find("\n    " + std::string(key.key) + ": ") != std::string::npos);
  }
  CHECK(help.find("in (-1, 0.5)") != std::string::npos);
  const std::string example(example_scene());
  REQUIRE(help.find(example) != std::string::npos);
  const Scene scene = read(example);
  CHECK(scene.adapt->policy == RefinementPolicy::directional);
  CHECK(scene.adapt->marking == Marking::bulk);
  CHECK(scene.loads[0].kind == LoadKind::total_by_area);
  CHECK(body_force(scene)(Eigen::Vector3d::Zero()) == Eigen::Vector3d(0, 0, -10));
  CHECK(base_mesh(scene).surfaces.at("tip") == base_mesh(scene).surfaces.at("x_max"));
  CHECK(scene.refinements[0].max == Eigen::Vector3d(0.1, 0.1, 0.1));
  CHECK(scene.material.kinematics == Kinematics::corotational);
}

TEST_CASE("a scene without optional sections has the defaults of the table", "[scene]") {
  const Scene scene = read(small_scene);
  CHECK(scene.solver.method == LinearMethod::automatic);
  CHECK(scene.solver.linear.relative_residual == 1e-6);
  CHECK_FALSE(scene.adapt.has_value());
  CHECK(scene.refinements.empty());
  CHECK_FALSE(scene.dimensionless);
  const AdaptRules adapt = *read(small_scene, {"adapt.steps=3"}).adapt;
  CHECK(adapt.steps == 3);
  CHECK(adapt.theta == 0.3);
  CHECK(adapt.refinement == RefinementTemplate{});
  CHECK(adapt.max_depth == 20);
}

TEST_CASE("a support with a gradient prescribes an affine displacement", "[scene]") {
  const Scene scene =
      read(small_scene, {"support[0].displacement=[1, 2, 3]", "support[0].gradient=[[0, 1, 0], [0, 0, 2], [3, 0, 0]]",
                         "support[0].components=[\"z\", \"x\"]"});
  const std::vector<SupportCondition> conditions = support_conditions(scene);
  REQUIRE(conditions.size() == 2);
  CHECK(conditions[0].normal == Eigen::Vector3d(0, 0, 1));
  CHECK(conditions[1].normal == Eigen::Vector3d(1, 0, 0));
  for (const SupportCondition& condition : conditions)
    CHECK(condition.displacement(Eigen::Vector3d(10, 20, 30)) == Eigen::Vector3d(21, 62, 33));
}

TEST_CASE("surfaces are planes of any direction or lists of nodes", "[scene]") {
  const Scene plane = read(small_scene + "[[surface]]\nname = \"end\"\nnormal = [-3, 0, 0]\npoint = [2, 7, 7]\n");
  CHECK(base_mesh(plane).surfaces.at("end") == std::vector<BaseFace>{{1, 1}});
  const Scene listed = read(small_mesh + "[[surface]]\nname = \"top\"\nnodes = [7, 6, 5, 4, 0]\n");
  CHECK(base_mesh(listed).surfaces.at("top") == std::vector<BaseFace>{{0, 5}});
}

TEST_CASE("a value outside its range is refused with line, field, value and range", "[scene][refusal]") {
  struct Case {
    std::string from, to, message;
  };
  const auto [from, to, message] = GENERATE(values<Case>({
      {"= 0.3", "= 0.6",
       "6: material.poisson_ratio: found 0.6, allowed a finite number in (-1, 0.5) (0.5 is the "
       "incompressible limit"},
      {"= 0.3", "= 0.5", "6: material.poisson_ratio: found 0.5, allowed a finite number in (-1, 0.5)"},
      {"= 0.3", "= nan", "6: material.poisson_ratio: found nan, allowed a finite number in (-1, 0.5)"},
      {"= 0.3", "= -1", "6: material.poisson_ratio: found -1, allowed a finite number in (-1, 0.5)"},
      {"= 0.3", "= \"0.3\"", "6: material.poisson_ratio: found \"0.3\", allowed a finite number in (-1, 0.5)"},
      {"= 1e3", "= inf", "5: material.youngs_modulus: found inf, allowed a finite number > 0"},
      {"= 1e3", "= 0", "5: material.youngs_modulus: found 0, allowed a finite number > 0"},
      {"= 1e3", "= 2e60",
       "5: material.youngs_modulus: found 2e+60, allowed a finite number > 0, of a magnitude of 1e-60 to 1e60 unless "
       "zero"},
      {"= 1e3", "= 5e-324", "5: material.youngs_modulus: found 5e-324, allowed a finite number > 0, of a magnitude"},
      {"[1, 0, 0]", "[0, 0, -1e61]",
       "11: load[0].traction[2]: found -1e+61, allowed three finite numbers, of a magnitude"},
      {"[2, 1, 1]\nc", "[2, 1, 1]\norigin = [1e20, 0, 0]\nc",
       "2: box.size: found an unsound mesh: coordinates along x: number 1 is 1e+20, but they must be finite and "
       "strictly ascending"},
      {"[2, 1, 1]\nc", "[2, -1, 1]\nc", "2: box.size[1]: found -1, allowed three finite numbers, each > 0"},
      {"[2, 1, 1]\nc", "[2, nan, 1]\nc", "2: box.size[1]: found nan, allowed three finite numbers, each > 0"},
      {"[2, 1, 1]\nc", "[2, 1]\nc", "2: box.size: found [2, 1], allowed three finite numbers, each > 0"},
      {"cells = [2", "cells = [0", "3: box.cells[0]: found 0, allowed three whole numbers, each in [1, 4096]"},
      {"cells = [2", "cells = [2.0", "3: box.cells[0]: found 2, allowed three whole numbers, each in [1, 4096]"},
      {"cells = [2, 1, 1]", "cells = [999, 999, 999]", "3: box.cells: found 997002999 cells in all, allowed at most"},
      {"[2, 1, 1]\nc", "[2, 1, 1]\nremoved_first = [0, 0, 0]\nremoved_last = [3, 1, 1]\nc",
       "4: box.removed_last[0]: found 3, allowed from 1 (past removed_first) to 2 (cells)"},
      {"[2, 1, 1]\nc", "[2, 1, 1]\nremoved_first = [0, 0, 0]\nremoved_last = [2, 1, 1]\nc",
       "4: box.removed_last: found a block that is the whole box, allowed a part of it"},
      {"poisson_ratio", "poison_ratio",
       "6: material.poison_ratio: unknown key, the nearest known one is \"poisson_ratio\", allowed youngs_modulus"},
      {"poisson_ratio = 0.3\n", "", "4: material.poisson_ratio: found nothing, required: a finite number in (-1, 0.5)"},
      {"[material]", "[materials]",
       "4: materials: unknown section, the nearest known one is \"material\", allowed box"},
      {"[material]", "[nail]\n[material]", "4: nail: unknown section, allowed box, mesh"},
      {"[box]", "nmae = \"a\"\n[box]", "1: nmae: unknown key, the nearest known one is \"name\", allowed name"},
      {"[box]", "name = \"../a\"\n[box]", "1: name: found \"../a\", allowed letters, digits"},
      {"[box]", "units = \"mm\"\n[box]", "1: units: found \"mm\", allowed \"SI\" or \"none\""},
      {"[[support]]", "[support]", "7: support: found a table, allowed the section [[support]]"},
      {"x_min", "x_mni", "8: support[0].surface: found \"x_mni\", allowed one of boundary, x_max, x_min"},
      {"\"x_min\"", "\"x_min\"\nnormal = [0, 0, 0]",
       "9: support[0].normal: found [0, 0, 0], allowed three finite numbers, not all zero"},
      {"\"x_min\"", "\"x_min\"\ncomponents = [\"x\", \"x\"]",
       "9: support[0].components: found [\"x\", \"x\"], allowed one to three of \"x\", \"y\", \"z\", none twice"},
      {"\"x_min\"", "\"x_min\"\nnormal = [1, 0, 0]\ncomponents = [\"x\"]",
       "10: support[0].components: found beside normal, allowed one of the two"},
      {"traction = [1, 0, 0]", "traction = [1, 0, 0]\ntotal_force = [1, 0, 0]",
       "11: load[0].traction: found 2 of traction, total_force and body_force, allowed exactly one"},
      {"traction = [1, 0, 0]", "traction = [1, 0, 0]\nshare = \"area\"",
       "12: load[0].share: found without total_force, allowed only with it"},
      {"traction = [1, 0, 0]", "body_force = [1, 0, 0]",
       "10: load[0].surface: found beside body_force, which acts on the whole body"},
      {"[box]\nsize = [2, 1, 1]\ncells = [2, 1, 1]\n", "",
       "1: box: found no geometry, required: exactly one of [box], [mesh], [gmsh], [organ]"},
      {"[material]", "[gmsh]\nfile = \"a\"\n[material]",
       "4: gmsh: found beside [box], allowed exactly one of [box], [mesh], [gmsh], [organ]"},
      {"= 0.3", "= = 0.3", "6: not TOML: "},
      {"[material]", "[box]", "4: not TOML: "},
  }));
  CAPTURE(from, to);
  check_begins(refusal(replaced(small_scene, from, to)), message);
}

TEST_CASE("what is added to a sound scene is checked, too", "[scene][refusal]") {
  struct Case {
    std::string added, message;
  };
  const auto [added, message] = GENERATE(values<Case>({
      {"[adapt]\ntheta = 0.3\n", "12: adapt.steps: found nothing, required: a whole number in [0, 1000]"},
      {"[adapt]\nsteps = 2\ntheta = 1.5\n", "14: adapt.theta: found 1.5, allowed a finite number in (0, 1]"},
      {"[adapt]\nsteps = 2\ntheta = 0\n", "14: adapt.theta: found 0, allowed a finite number in (0, 1]"},
      {"[adapt]\nsteps = 2\nmarking = \"threshold\"\n",
       "12: adapt.threshold: found nothing, needed with marking = \"threshold\": a finite number > 0"},
      {"[adapt]\nsteps = 2\ntemplate = \"2x5x2\"\n", "14: adapt.template: found \"2x5x2\", allowed a text \"NxMxK\""},
      {"[refine]\nall = true\n", "12: refine: found a table, allowed the section [[refine]]"},
      {"[[refine]]\nlevels = 2\n", "12: refine[0].all: found nothing, exactly one of all = true and a region"},
      {"[[refine]]\nmin = [0, 0, 0]\n", "12: refine[0].max: found nothing, min and max go together"},
      {"[[refine]]\nmin = [0, 0, 0]\nmax = [1, 0, 1]\n", "14: refine[0].max: found a corner that is not above min"},
      {"[[refine]]\nall = true\nlevels = 99\n", "14: refine[0].levels: found 99, allowed a whole number in [1, 20]"},
      {"[solver]\nrelative_residual = 0.0\n",
       "13: solver.relative_residual: found 0, allowed a finite number in [1e-14, 1)"},
      {"[[quantity]]\nkind = \"displacement\"\n",
       "12: quantity[0].point: found nothing, needed with kind = \"displacement\""},
      {"[[quantity]]\nkind = \"displacement\"\npoint = [0, 9, 0]\n",
       "14: quantity[0].point[1]: found 9.000000, allowed in [0.000000, 1.000000]"},
      {"[[quantity]]\nkind = \"energy\"\n[[quantity]]\nkind = \"energy\"\n",
       "14: quantity[1].name: found \"energy\" twice"},
      {"[[surface]]\nname = \"x_min\"\nnodes = [0]\n", "13: surface[0].name: found \"x_min\", allowed a name that no"},
      {"[[surface]]\nname = \"a\"\nnodes = [0]\n", "14: surface[0].nodes: found no face of the boundary there"},
      {"[[surface]]\nname = \"a\"\nnodes = [0, 12]\n", "14: surface[0].nodes[1]: found node 12, allowed 0 to 11"},
      {"[[surface]]\nname = \"a\"\nnormal = [1, 0, 0]\n", "12: surface[0].point: found nothing, needed with normal"},
      {"[[surface]]\nname = \"a\"\nnormal = [1, 0, 0]\npoint = [0.3, 0, 0]\n",
       "14: surface[0].normal: found no face of the boundary there"},
  }));
  CAPTURE(added);
  check_begins(refusal(small_scene + added), message);
}

TEST_CASE("a point of interest in the notch of a box is refused, with the three numbers and its line",
          "[scene][refusal]") {
  std::string notched = small_scene;
  notched.replace(notched.find("cells = [2, 1, 1]"), 17,
                  "cells = [2, 2, 1]\nremoved_first = [1, 1, 0]\nremoved_last = [2, 2, 1]");
  const std::string point = "[[quantity]]\nkind = \"displacement\"\npoint = ";
  CHECK(refusal(notched + point + "[0.5, 0.75, 0.5]\n") == "accepted");
  CHECK(refusal(notched + point + "[1.0, 1.0, 0.5]\n") == "accepted");  // on the notch's own faces
  check_begins(refusal(notched + point + "[1.5, 0.75, 0.5]\n"),
               "16: quantity[0].point: found [1.500000, 0.750000, 0.500000], where there is no cell");
}

TEST_CASE("a mesh in the scene that is not sound is refused with the line of its cell", "[scene][refusal]") {
  REQUIRE(refusal(small_mesh) == "accepted");
  struct Case {
    std::string from, to, message;
  };
  const auto [from, to, message] = GENERATE(values<Case>({
      {"5, 6, 7],", "5, 6, 8],", "5: mesh.cells[0]: found node 8, allowed 0 to 7 (mesh.nodes)"},
      {"5, 6, 7],", "5, 6, -1],", "5: mesh.cells[0][7]: found -1, allowed a list of one or more lists of whole"},
      {"5, 6, 7],", "5, 6],", "5: mesh.cells[0]: found 7 corners, allowed 8"},
      {"5, 6, 7],", "5, 6, 6],", "5: mesh.cells[0]: found the same corner twice, allowed 8 distinct ones"},
      {"[0, 1, 2, 3, 4, 5, 6, 7]", "[4, 5, 6, 7, 0, 1, 2, 3]", "5: mesh.cells[0]: found an inverted cell, Jacobian"},
      {"[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]", "[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]",
       "5: mesh.cells[0]: found a flat cell"},
      {"6, 7],\n", "6, 7],\n  [0, 1, 2, 3, 4, 5, 6, 7],\n",
       "6: mesh.cells[1]: found a cell on the same side of a face"},
      {"[0, 1, 1]]", "[0, 1, 1], [5, 5, 5]]", "3: mesh.nodes[8]: found a node without a cell"},
      {"[0, 1, 1]]", "[0, 1, nan]]", "3: mesh.nodes[7][2]: found nan, allowed a list of one or more triples of finite"},
      {"[0, 1, 1]]", "[0, 1]]", "3: mesh.nodes[7]: found [0, 1], allowed a list of one or more triples of finite"},
      {"[mesh]", "[mesh]\nshape = \"tetrahedron\"", "6: mesh.cells[0]: found 8 corners, allowed 4"},
      {"[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0],", "[[0, 0, -1e15], [1, 0, -1e15], [1, 1, -1e15], [0, 1, -1e15],",
       "5: mesh.cells[0]: found a flat cell, without edges at the centre, allowed those that are longer than 2e-14 of"},
  }));
  CAPTURE(from, to);
  check_begins(refusal(replaced(small_mesh, from, to)), message);
}

TEST_CASE("several body forces add up, beside loads on surfaces", "[scene]") {
  const Scene scene = read(small_scene, {"load[1].body_force=[0, 0, 3]", "load[2].body_force=[1, 0, -0.5]"});
  CHECK(scene.body_force == Eigen::Vector3d(1, 0, 2.5));
  CHECK(scene.loads.size() == 1);
}

TEST_CASE("overrides are applied before the checks and named in messages", "[scene][override]") {
  const Scene scene = read(small_scene, {"material.poisson_ratio=0.2", "material.poisson_ratio = 0.25", "name=other",
                                         "load[0].traction=[0, 0, 2]", "load[1].body_force=[0, 0, 3]",
                                         "solver.method=direct", "box.cells[0]=5"});
  CHECK(scene.name == "other");
  CHECK(scene.material.poisson_ratio == 0.25);
  CHECK(scene.loads[0].value == Eigen::Vector3d(0, 0, 2));
  CHECK(scene.body_force == Eigen::Vector3d(0, 0, 3));
  CHECK(scene.solver.method == LinearMethod::direct);
  CHECK(std::get<BoxMeshOptions>(scene.geometry).cells[0] == 5);

  struct Case {
    std::string set, message;
  };
  const auto [set, message] = GENERATE(values<Case>({
      {"material.poisson_ratio=0.6",
       "--set material.poisson_ratio=0.6: material.poisson_ratio: found 0.6, allowed a finite number in (-1, 0.5)"},
      {"material.poisson_ratio=wide", "--set material.poisson_ratio=wide: material.poisson_ratio: found wide, allowed"},
      {"material.nu=0.3", "--set material.nu=0.3: material.nu: unknown key, allowed youngs_modulus"},
      {"box.size=[1, -1, 1]", "--set box.size=[1, -1, 1]: box.size[1]: found -1, allowed"},
      {"load[7].traction=[0, 0, 0]", "--set load[7].traction=[0, 0, 0]: load[7]: found index 7, allowed 0 to 1"},
      {"adapt.theta=0.3", "--set adapt.theta=0.3: adapt.steps: found nothing, required"},
      {"support.surface=x_max", "--set support.surface=x_max: support is no section here; of several write support[0]"},
      {"name", "--set name: found no '=', allowed KEY=VALUE"},
      {"a.b.c=1", "--set a.b.c=1: found \"a.b.c\", allowed KEY, SECTION.KEY or SECTION[INDEX].KEY"},
      {"=1", "--set =1: found \"\", allowed KEY"},
      {"name=", "--set name=: name: found \"\", allowed a text that is not empty"},
      {"box.origin=1\nmaterial=2",
       "--set box.origin=1 material=2: box.origin: found 1 material=2, allowed a TOML value"},
  }));
  CAPTURE(set);
  check_begins(refusal(small_scene, {set}), message);
}

TEST_CASE("a body that is not held is refused, with the number of motions left", "[scene][refusal]") {
  const auto [set, left] =
      GENERATE(table<std::string, int>({{"support[0].components=[\"x\"]", 3}, {"support[0].normal=[0, 1, 0]", 4}}));
  CAPTURE(set);
  const Scene scene = read(small_scene, Strings{set});
  try {
    check_base_held(scene);
    FAIL("accepted");
  } catch (const SceneError& error) {
    const std::string message = error.what();
    CHECK(message.find(scene.file + ":7: support: the body is not held") == 0);
    CHECK(message.find("leave " + std::to_string(left) + " of its six rigid motions free, allowed 0") !=
          std::string::npos);
  }
}

TEST_CASE("a body that shares no face with the held one is refused by its cells and place", "[scene][refusal]") {
  // Unit cubes, the first one clamped: the second one apart, hinged at an edge, at a node, and joined by a face.
  struct Case {
    Eigen::Vector3d at;
    std::string found;
  };
  const auto [at, found] = GENERATE(values<Case>({
      {{3, 0, 0},
       "of 1 cell around (3.5, 0.5, 0.5), one of 2 that share no face, is not held, found 1 supports that "
       "leave 6 of its six rigid motions free, allowed 0"},
      {{1, 1, 0}, "of 1 cell around (1.5, 1.5, 0.5), one of 2"},
      {{1, 1, 1}, "of 1 cell around (1.5, 1.5, 1.5), one of 2"},
      {{1, 0, 0}, "accepted"},
  }));
  CAPTURE(at.transpose());
  const std::array<std::array<int, 3>, 8> corner = {
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
  std::vector<Eigen::Vector3d> nodes;
  std::string node_list, cell_list;
  for (const Eigen::Vector3d& origin : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(at)}) {
    cell_list += "  [";
    for (const auto& [x, y, z] : corner) {
      const Eigen::Vector3d node = origin + Eigen::Vector3d(x, y, z);
      const auto known = std::find(nodes.begin(), nodes.end(), node);
      cell_list += std::to_string(known - nodes.begin()) + ",";
      if (known != nodes.end()) continue;
      nodes.push_back(node);
      for (int k = 0; k < 3; ++k) node_list += (k == 0 ? "[" : ",") + std::to_string(node[k]);
      node_list += "],\n";
    }
    cell_list += "],\n";
  }
  const Scene scene = read("[mesh]\nnodes = [" + node_list + "]\ncells = [\n" + cell_list +
                           "]\n[material]\nyoungs_modulus = 1e3\npoisson_ratio = 0.3\n"
                           "[[support]]\nsurface = \"x_min\"\n");
  std::string message = "accepted";
  try {
    check_base_held(scene);
  } catch (const SceneError& error) {
    message = error.what();
  }
  CHECK(message.find(found) != std::string::npos);
}

TEST_CASE("what is not a scene at all is refused in few words", "[scene][refusal]") {
  const auto message_of = [](const std::filesystem::path& path) -> std::string {
    try {
      (void)read_scene(path);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK(message_of("/no/such/scene.toml") == "/no/such/scene.toml: no such file");
  const auto directory = std::filesystem::temp_directory_path();
  CHECK(message_of(directory) == directory.string() + ": found a directory, allowed a file");
  CHECK(message_of("/dev/null") == "/dev/null: not a regular file");
  CHECK(refusal("") == "1: the file is empty");
  check_begins(refusal("# nothing\n"), "1: material: found nothing, required: the section [material]");

  const TemporaryFile large("large.toml", "#");
  std::filesystem::resize_file(large.path(), 100'000'000);
  CHECK(message_of(large.path()) == large.path().string() + ": found 100000000 bytes, allowed at most 16777216");
}

TEST_CASE("nesting of any depth is refused", "[scene][refusal]") {
  const auto repeated = [](const std::string& part, int times) {
    std::string text;
    for (int i = 0; i < times; ++i) text += part;
    return text;
  };
  const int deep = 300'000;  // enough to exhaust the stack of a recursive parser
  check_begins(refusal("\na = " + repeated("[", deep)), "2: not TOML: ");
  check_begins(refusal("a = " + repeated("{a = ", deep)), "1: not TOML: ");
  check_begins(refusal("\n\n" + repeated("a.", deep) + "a = 1"), "3: found a key with more than 32 dots, allowed");
  check_begins(refusal("[" + repeated("a . ", deep) + "a]"), "1: found a key with more than 32 dots, allowed");
  check_begins(refusal(repeated("\"a,\".", deep) + "a = 1"), "1: found a key with more than 32 dots, allowed");
  check_begins(refusal("name = \"\"\"\n\"\n\"\"\"\n" + repeated("a.", deep) + "a = 1"), "4: found a key with more");
  check_begins(refusal("name = \"" + repeated(".", 100) + "\"\n" + small_scene), "1: name: found");
  // A text of several lines may end with its own quotation marks, which begin no other text.
  for (const std::string quote : {"\"", "'"})
    for (const int more : {1, 2}) {
      const std::string text = repeated(quote, 3) + "\n" + repeated(quote, 3 + more);
      check_begins(refusal("x = {k = " + text + ", " + repeated("a.", deep) + "a = 1}"),
                   "2: found a key with more than 32 dots, allowed");
    }
  check_begins(refusal("name = \"\"\"\\\n\"\"\"\n" + repeated("a.", deep) + "a = 1"), "3: found a key with more");
}

TEST_CASE("characters outside ASCII are allowed in texts and comments only", "[scene][refusal]") {
  const std::string described = "name = \"a\" # \u02e2\ndescription = \"\"\"m\u00b2\n'\u3001' \"\"\"\"\n" + small_scene;
  CHECK(read(described).description == "m\u00b2\n'\u3001' \"");
  CHECK(refusal("\ufeff" + described) == "accepted");  // the mark with which some editors begin a file
  // Behind a number, where the parser asks each of them whether it is white space; and where a key may begin.
  for (const std::string character : {"\u02e2", "\u00e9", "\u2e80", "\ufebf", "\U0001f600"}) {
    CAPTURE(character);
    check_begins(refusal(replaced(small_scene, "= 0.3", "= 0.3" + character)), "6: not TOML: ");
    check_begins(refusal(replaced(small_scene, "= 0.3", "= 0.3\"" + character + "\"")), "6: not TOML: ");
    check_begins(refusal(replaced(small_scene, "poisson", character + "poisson")), "6: not TOML: ");
    check_begins(refusal(small_scene, {"box.size=[2, 1, " + character + "1]"}), "--set box.size=[2, 1, ");
  }
  CHECK(refusal(replaced(small_scene, "poisson", "\xffpoisson")).find(": not TOML: ") != std::string::npos);
}

TEST_CASE("no noise and no changed byte does more than a refusal", "[scene][refusal][fuzz]") {
  std::mt19937 random(20240611);
  int refused = 0, accepted = 0;
  const std::string original(example_scene());
  for (int trial = 0; trial < 400; ++trial) {
    std::string text = original;
    if (trial % 8 == 0) text.assign(1000 + random() % 100000, ' ');
    if (trial % 4 == 1) text.resize(random() % text.size());
    const std::size_t changes = trial % 8 == 0 ? text.size() : 1 + random() % 3;
    for (std::size_t k = 0; k < changes && !text.empty(); ++k)
      text[random() % text.size()] =
          trial % 2 == 0 ? static_cast<char>(random() % 256) : "0123456789.-[]{}=\"'\n,e_"[random() % 23];
    CAPTURE(trial);
    refusal(text) == "accepted" ? ++accepted : ++refused;
  }
  CHECK(refused > 200);
  CHECK(accepted > 10);  // some changes fall into comments and texts
}
