#include "core/scene/gmsh_reader.hpp"

#include <random>
#include <string>

#include "core/scene/scene_error.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

namespace {

/// Two unit cubes side by side in x, with point and line elements that do not matter, a node that no cell uses, tags
/// with gaps, and the surfaces "left" (named) and 8 (unnamed).
const std::string two_cubes = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 7 "left"
3 9 "body"
$EndPhysicalNames
$Nodes
13
10 0 0 0
11 1 0 0
12 2 0 0
20 0 1 0
21 1 1 0
22 2 1 0
30 0 0 1
31 1 0 1
32 2 0 1
40 0 1 1
41 1 1 1
42 2 1 1
99 5 5 5
$EndNodes
$Elements
6
1 15 2 0 1 10
2 1 2 0 1 10 11
3 3 2 7 1 10 30 40 20
4 3 2 8 2 12 22 42 32
5 5 2 9 1 10 11 21 20 30 31 41 40
6 5 2 9 1 11 12 22 21 31 32 42 41
$EndElements
)";

/// One tetrahedron in format 4.1 whose face x = 0 is in two physical groups; its nodes carry parametric coordinates.
const std::string one_tetrahedron = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
2 1 "skin"
2 2 "left"
$EndPhysicalNames
$Comments
anything at all 1 2 3
$EndComments
$Entities
1 1 1 1
1 0 0 0 0
1 0 0 0 1 0 0 0 2 1 -1
4 0 0 0 0 1 1 2 1 2 1 1
1 0 0 0 1 1 1 0 1 4
$EndEntities
$Nodes
2 4 1 4
2 4 1 3
1
2
3
0 0 0 0 0
0 1 0 1 0
0 0 1 0 1
3 1 0 1
4
1 0 0
$EndNodes
$Elements
2 2 1 2
2 4 2 1
1 1 2 3
3 1 4 1
2 1 4 2 3
$EndElements
)";

BaseMesh read_mesh(const std::string& text) {
  const TemporaryFile file("mesh.msh", text);
  return read_gmsh(file.path());
}

/// The message without the directory of the file; fails the test when the file is accepted.
std::string mesh_refusal(const std::string& text) {
  const TemporaryFile file("mesh.msh", text);
  try {
    (void)read_gmsh(file.path());
  } catch (const SceneError& error) {
    const std::string message = error.what();
    REQUIRE(message.rfind(file.path().string() + ":", 0) == 0);
    return message.substr(file.path().string().size() + 1);
  }
  return "accepted";
}

}  // namespace

TEST_CASE("a gmsh file of hexahedra gives its cells in our corner order and its physical groups as surfaces",
          "[gmsh]") {
  const BaseMesh mesh = read_mesh(two_cubes);
  REQUIRE(mesh.shape == CellShape::hexahedron);
  CHECK(mesh.nodes.cols() == 12);  // the thirteenth belongs to no cell
  REQUIRE(mesh.cells.size() == 2);
  for (int c = 0; c < 8; ++c)
    CHECK(mesh.nodes.col(mesh.cells[1][c]) == Eigen::Vector3d(1 + (c & 1), (c >> 1) & 1, (c >> 2) & 1));
  REQUIRE(mesh.surfaces.size() == 2);
  CHECK(mesh.surfaces.at("left") == std::vector<BaseFace>{{0, 0}});
  CHECK(mesh.surfaces.at("physical_8") == std::vector<BaseFace>{{1, 1}});
  CHECK(validate(mesh).empty());
}

TEST_CASE("a gmsh 4.1 file gives tetrahedra, and a face of two physical groups lies in both surfaces", "[gmsh]") {
  const BaseMesh mesh = read_mesh(one_tetrahedron);
  REQUIRE(mesh.shape == CellShape::tetrahedron);
  REQUIRE(mesh.nodes.cols() == 4);
  CHECK(mesh.nodes.col(mesh.cells[0][1]) == Eigen::Vector3d(1, 0, 0));
  CHECK(mesh.cells[0][4] == -1);
  CHECK(mesh.surfaces.at("skin") == std::vector<BaseFace>{{0, 1}});
  CHECK(mesh.surfaces.at("left") == mesh.surfaces.at("skin"));
  CHECK(validate(mesh).empty());
}

TEST_CASE("line ends of another system do not matter", "[gmsh]") {
  std::string text;
  for (const char c : two_cubes) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  CHECK(read_mesh(text).cells == read_mesh(two_cubes).cells);
  CHECK(read_mesh(text).surfaces == read_mesh(two_cubes).surfaces);
}

TEST_CASE("a gmsh file that is not what we read is refused with line, field, value and range", "[gmsh][refusal]") {
  struct Case {
    std::string from, to, message;
  };
  const auto [from, to, message] = GENERATE(values<Case>({
      {"2.2 0 8", "2.2 1 8", "2: file type: found 1, binary, allowed 0, ASCII"},
      {"2.2 0 8", "3.0 0 8", "2: format version: found 3.0, allowed 2.2 or 4.1"},
      {"$MeshFormat", "$Format", "1: $MeshFormat: found \"$Format\", allowed $MeshFormat"},
      {"12 2 0 0", "12 2 0 nan", "13: coordinate: found \"nan\", allowed a finite number"},
      {"12 2 0 0", "12 2 0 1e999", "13: coordinate: found \"1e999\", allowed a finite number"},
      {"12 2 0 0", "12 2 0 0x1", "13: coordinate: found \"0x1\", allowed a finite number"},
      {"12 2 0 0", "-12 2 0 0", "13: node tag: found \"-12\", allowed a whole number in [1,"},
      {"12 2 0 0", "11 2 0 0", "13: node 11: found twice, allowed once"},
      {"13\n10", "14\n10", "24: node tag: found \"$EndNodes\", allowed a whole number"},
      {"13\n10", "12\n10", "23: $EndNodes: found \"99\", allowed $EndNodes"},
      {"13\n10", "999999999\n10", "24: node tag: found \"$EndNodes\""},
      {"13\n10", "99999999999999999999\n10", "10: number of nodes: found \"99999999999999999999\", allowed"},
      {"5 5 2 9", "5 17 2 9", "31: element type: found 17, of higher order or unknown, allowed first order"},
      {"5 5 2 9", "5 6 2 9", "31: element type: found 6, a prism, allowed hexahedra (5) or tetrahedra (4)"},
      {"5 5 2 9", "5 7 2 9", "31: element type: found 7, a pyramid, allowed hexahedra (5) or tetrahedra (4)"},
      {"6 5 2 9 1 11 12 22 21 31 32 42 41", "6 4 2 9 1 11 12 22 31",
       "32: element 6: found hexahedra and tetrahedra mixed, allowed one shape"},
      {"31 32 42 41\n", "31 32 42 77\n", "32: element 6: found node 77, allowed a node of $Nodes (10 to 99)"},
      {"31 32 42 41\n", "31 32 42\n", "33: node of element: found \"$EndElements\", allowed a whole number"},
      {"31 32 42 41\n", "31 32 42 42\n", "32: element 6: found the same corner twice, allowed 8 distinct ones"},
      {"11 12 22 21 31 32 42 41", "31 32 42 41 11 12 22 21", "32: element 6: found an inverted cell"},
      {"12 22 21 31 32 42 41", "20 10 21 31 30 40 41", "32: element 6: found an inverted cell"},
      {"11 12 22 21 31 32 42 41", "10 11 21 20 30 31 41 40",
       "32: element 6: found a cell on the same side of a face as a cell before it, allowed one on each side"},
      {"22 2 1 0", "22 2 -3 0", "32: element 6: found a"},
      {"12 2 0 0", "12 2 0 -9e15", "32: element 6: found a"},
      {"42 2 1 1", "42 2e200 1 1", "32: element 6: found a flat cell, without edges at the centre, allowed"},
      {"10 30 40 20", "11 31 41 21", "29: element 3: found a face of a physical surface that is not on the boundary"},
      {"2 7 \"left\"", "2 7 left", "6: physical name: found \"left\", allowed a name in double quotes"},
      {"$EndPhysicalNames\n", "$EndPhysicalNames\nnoise\n",
       "9: section: found noise, allowed a section such as $Nodes"},
      {"$EndPhysicalNames\n", "$EndPhysicalNames\n$Open\n",
       "9: $EndOpen: found the end of the file, allowed a section that is closed"},
      {"$EndPhysicalNames\n", "$EndPhysicalNames\n$\x1b[2J\n",
       "9: $End?[2J: found the end of the file, allowed a section that is closed"},
      {"2 7 \"left\"", "2 7 \"left", "6: physical name: found \"\"left\", allowed a name in double quotes"},
      {"2 7 \"left\"", "2 7 \"\"", "6: physical name: found \"\"\"\", allowed a name in double quotes"},
  }));
  CAPTURE(from, to);
  const std::string found = mesh_refusal(replaced(two_cubes, from, to));
  CHECK(found.substr(0, message.size()) == message);
}

TEST_CASE("many physical names may stand on one line", "[gmsh]") {
  constexpr int count = 100'000;  // in seconds if each of them looked for the end of the line
  std::string names = std::to_string(count) + "\n2 7 \"left\"";
  for (int i = 1; i < count; ++i) names += " 2 " + std::to_string(100 + i) + " \"unused\"";
  CHECK(read_mesh(replaced(two_cubes, "2\n2 7 \"left\"\n3 9 \"body\"", names)).surfaces.contains("left"));
}

TEST_CASE("a surface is in 32 physical groups at most, or faces times groups would outgrow the file",
          "[gmsh][refusal]") {
  const auto entity = [](int first, int past) {
    std::string line = "4 0 0 0 0 1 1 " + std::to_string(past - first);
    for (int group = first; group < past; ++group) line += " " + std::to_string(group);
    return line + " 1 1\n";
  };
  const auto with = [](const std::string& entities) {
    return replaced(one_tetrahedron, "4 0 0 0 0 1 1 2 1 2 1 1\n", entities);
  };
  CHECK(read_mesh(with(entity(1, 33))).surfaces.size() == 32);
  CHECK(mesh_refusal(with(entity(1, 34))) == "16: physical tag: found more than 32 of surface 4, allowed as many");
  const std::string twice = replaced(with(entity(1, 33) + entity(33, 35)), "1 1 1 1\n", "1 1 2 1\n");
  CHECK(mesh_refusal(twice) == "17: physical tag: found more than 32 of surface 4, allowed as many");
}

TEST_CASE("counts of a 4.1 file that do not hold are refused", "[gmsh][refusal]") {
  struct Case {
    std::string from, to, message;
  };
  const auto [from, to, message] = GENERATE(values<Case>({
      {"2 4 1 4\n", "2 5 1 4\n", "30: number of nodes: found 4 in the blocks, allowed the 5 announced"},
      {"2 2 1 2\n", "2 3 1 2\n", "37: number of elements: found 2 in the blocks, allowed the 3 announced"},
      {"2 4 1 3\n1", "2 4 1 900000000\n1", "25: node tag: found \"0\", allowed a whole number in [1,"},
      {"2 4 1 3\n1", "2 4 2 3\n1", "21: parametric flag: found \"2\", allowed a whole number in [0, 1]"},
      {"2 1 4 2 3", "2 1 4 3 2", "37: element 2: found an inverted cell"},
      {"1 0 0\n$EndNodes", "0 1 1\n$EndNodes", "37: element 2: found a flat cell"},
  }));
  CAPTURE(from, to);
  const std::string found = mesh_refusal(replaced(one_tetrahedron, from, to));
  CHECK(found.substr(0, message.size()) == message);
}

TEST_CASE("a gmsh file without a section that it needs is refused", "[gmsh][refusal]") {
  const std::string format = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  CHECK(mesh_refusal(format) == "3: $Nodes: found nothing, required: the section $Nodes");
  CHECK(mesh_refusal(format + "$Nodes\n1\n1 0 0 0\n$EndNodes\n") ==
        "7: $Elements: found nothing, required: the section $Elements");
  CHECK(mesh_refusal(format + "$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 15 0 1\n$EndElements\n") ==
        "8: $Elements: found no hexahedra and no tetrahedra, allowed one or more");
  CHECK(mesh_refusal("") == "1: the file is empty");
}

TEST_CASE("no cut and no noise in a gmsh file does more than a refusal", "[gmsh][refusal][fuzz]") {
  std::mt19937 random(20240611);
  int refused = 0, accepted = 0;
  for (const std::string& original : {two_cubes, one_tetrahedron})
    for (int trial = 0; trial < 400; ++trial) {
      std::string text = original;
      if (trial % 4 == 0) text.resize(random() % text.size());
      for (int k = 0; k < 1 + trial % 3 && !text.empty(); ++k)
        text[random() % text.size()] =
            trial % 2 == 0 ? static_cast<char>(random() % 256) : "0123456789.-$ \n\"e"[random() % 17];
      CAPTURE(text);
      const TemporaryFile file("mesh.msh", text);
      try {
        const BaseMesh mesh = read_gmsh(file.path());
        CHECK(mesh.nodes.allFinite());
        ++accepted;
      } catch (const SceneError&) {
        ++refused;
      }
    }
  CHECK(refused > 400);  // most changes hit something that matters
  CHECK(accepted > 10);  // and some hit a coordinate's digit or a name
}
