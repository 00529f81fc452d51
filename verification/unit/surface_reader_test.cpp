#include "core/scene/surface_reader.hpp"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>

#include "core/scene/scene_error.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/surface_samples.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

namespace {

std::string text_of(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

std::string text_of(const Eigen::Vector3d& x) { return text_of(x[0]) + " " + text_of(x[1]) + " " + text_of(x[2]); }

template <class Scalar>
void put(std::string& bytes, Scalar value, bool big_endian = false) {
  std::array<char, sizeof(Scalar)> raw = std::bit_cast<std::array<char, sizeof(Scalar)>>(value);
  if (big_endian) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.begin(), raw.end());
}

std::string text_stl(const TriangleSurface& surface) {
  std::string text = "solid a sphere\n";
  for (const auto& corners : surface.triangles) {
    text += " facet normal nan 0 0\n  outer loop\n";
    for (const int v : corners) text += "   vertex " + text_of(surface.vertices.col(v)) + "\n";
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid a sphere\n";
}

std::string binary_stl(const TriangleSurface& surface) {
  std::string bytes = "solid, though binary";
  bytes.resize(80, ' ');
  put(bytes, static_cast<std::uint32_t>(surface.triangles.size()));
  for (const auto& corners : surface.triangles) {
    bytes.append(12, '\xff');
    for (const int v : corners)
      for (int axis = 0; axis < 3; ++axis) put(bytes, static_cast<float>(surface.vertices(axis, v)));
    put(bytes, std::uint16_t{0});
  }
  return bytes;
}

/// Corners written in all four ways, the last counting back from the end.
std::string obj_text(const TriangleSurface& surface) {
  std::string text = "# a sphere\nmtllib none.mtl\no sphere\n";
  for (int v = 0; v < surface.vertices.cols(); ++v)
    text += "v " + text_of(surface.vertices.col(v)) + (v % 2 ? " 1.0\n" : "\r\n");
  text += "vn 0 0 1\nvt 0 0\ns off\n";
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    text += t % 3 == 2 ? "f \\\n" : "f";
    for (const int v : surface.triangles[t]) {
      const std::string number = std::to_string(v + 1), back = std::to_string(v - surface.vertices.cols());
      text += " " + std::array<std::string, 4>{number, number + "/1", number + "//1", back + "/1/1"}[t % 4];
    }
    text += "\n";
  }
  return text;
}

/// With a property, a list and an element that do not matter, one of them not finite.
std::string text_ply(const TriangleSurface& surface) {
  std::string text = "ply\nformat ascii 1.0\ncomment a sphere\nelement vertex " +
                     std::to_string(surface.vertices.cols()) +
                     "\nproperty float nx\nproperty double x\nproperty double y\nproperty double z\nelement camera 1\n"
                     "property list uchar int view\nelement face " +
                     std::to_string(surface.triangles.size()) +
                     "\nproperty list uchar int vertex_indices\nproperty uchar red\nend_header\n";
  for (int v = 0; v < surface.vertices.cols(); ++v) text += "nan " + text_of(surface.vertices.col(v)) + "\n";
  text += "2 17 18\n";
  for (const auto& [a, b, c] : surface.triangles)
    text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + " 255\n";
  return text;
}

/// Indices and counts of the types named by their size.
template <class Coordinate, class Count, class Index>
std::string binary_ply(const TriangleSurface& surface, bool big_endian, const std::string& count_type,
                       const std::string& index_type) {
  std::string bytes = std::string("ply\r\nformat binary_") + (big_endian ? "big" : "little") +
                      "_endian 1.0\r\nelement face " + std::to_string(surface.triangles.size()) + "\r\nproperty list " +
                      count_type + " " + index_type + " vertex_index\r\nelement vertex " +
                      std::to_string(surface.vertices.cols()) + "\r\n";
  for (const std::string axis : {"x", "y", "z"})
    bytes += std::string("property ") + (sizeof(Coordinate) == 4 ? "float" : "float64") + " " + axis + "\r\n";
  bytes += "property short label\r\nend_header\r\n";
  for (const auto& corners : surface.triangles) {
    put(bytes, Count{3}, big_endian);
    for (const int v : corners) put(bytes, static_cast<Index>(v), big_endian);
  }
  for (int v = 0; v < surface.vertices.cols(); ++v) {
    for (int axis = 0; axis < 3; ++axis) put(bytes, static_cast<Coordinate>(surface.vertices(axis, v)), big_endian);
    put(bytes, std::int16_t{-1}, big_endian);
  }
  return bytes;
}

/// Tags with gaps; every third triangle turned, as gmsh may have it where entities meet.
std::string gmsh(const TriangleSurface& surface, bool version_2) {
  const auto nodes = std::to_string(surface.vertices.cols()), count = std::to_string(surface.triangles.size());
  std::string text =
      version_2 ? "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + nodes + "\n"
                : "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 " + nodes + " 1 9999\n2 1 0 " + nodes + "\n";
  for (int pass = version_2 ? 1 : 0; pass < 2; ++pass)
    for (int v = 0; v < surface.vertices.cols(); ++v)
      text += (version_2 || pass == 0 ? std::to_string(10 * v + 5) + (version_2 ? " " : "\n") : "") +
              (pass == 1 ? text_of(surface.vertices.col(v)) + "\n" : "");
  text += "$EndNodes\n$Elements\n" + (version_2 ? count + "\n" : "1 " + count + " 1 9999\n2 1 2 " + count + "\n");
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    auto [a, b, c] = surface.triangles[t];
    if (t % 3 == 1) std::swap(b, c);
    text += std::to_string(t + 1) + (version_2 ? " 2 2 0 1 " : " ") + std::to_string(10 * a + 5) + " " +
            std::to_string(10 * b + 5) + " " + std::to_string(10 * c + 5) + "\n";
  }
  return text + "$EndElements\n";
}

TriangleSurface read(const std::string& name, const std::string& contents) {
  const TemporaryFile file(name, contents);
  return read_surface(file.path());
}

/// The message without the directory of the file; "accepted" where there is none.
std::string refusal(const std::string& name, const std::string& contents) {
  const TemporaryFile file(name, contents);
  try {
    (void)read_surface(file.path());
  } catch (const SceneError& error) {
    const std::string message = error.what();
    REQUIRE(message.rfind(file.path().string() + ":", 0) == 0);
    return message.substr(file.path().string().size() + 1);
  }
  return "accepted";
}

/// The same triangles, but for which corner of each is named first.
bool same_triangles(TriangleSurface a, TriangleSurface b) {
  for (TriangleSurface* surface : {&a, &b})
    for (auto& corners : surface->triangles)
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return a.vertices == b.vertices && a.triangles == b.triangles;
}

}  // namespace

TEST_CASE("a sphere is the same surface out of every format", "[surface][reader]") {
  const TriangleSurface sphere = octasphere(2, 0.1, {0.01, -0.02, 0.03});
  REQUIRE(sphere.triangles.size() == 128);
  REQUIRE(sphere.vertices.cols() == 66);
  const bool big = true, little = false;
  const std::vector<std::pair<std::string, std::string>> files = {
      {"sphere.stl", text_stl(sphere)},
      {"sphere.STL", replaced(text_stl(sphere), "solid a sphere", "solid")},
      {"sphere.stl", binary_stl(sphere)},
      {"sphere.obj", obj_text(sphere)},
      {"sphere.ply", text_ply(sphere)},
      {"sphere.ply", binary_ply<float, std::uint8_t, std::int32_t>(sphere, little, "uchar", "int")},
      {"sphere.ply", binary_ply<float, std::int32_t, std::uint32_t>(sphere, big, "int32", "uint32")},
      {"sphere.ply", binary_ply<double, std::uint16_t, std::int16_t>(sphere, big, "ushort", "short")},
      {"sphere.ply", binary_ply<double, std::int8_t, std::uint8_t>(sphere, little, "int8", "uint8")},
      {"sphere.msh", gmsh(sphere, true)},
      {"sphere.msh", gmsh(sphere, false)},
      // by content, whatever the name says
      {"sphere", binary_stl(sphere)},
      {"sphere", text_stl(sphere)},
      {"sphere.stl", text_ply(sphere)},
      {"sphere.dat", gmsh(sphere, true)},
  };
  for (const auto& [name, contents] : files) {
    CAPTURE(name, contents.substr(0, 60));
    CHECK(same_triangles(read(name, contents), sphere));
  }
  CHECK_FALSE(same_triangles(read("sphere.stl", text_stl(turned(sphere))), sphere));
}

TEST_CASE("a face of more corners is cut as a fan from its first", "[surface][reader]") {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\n";
  const std::vector<std::array<int, 3>> fan = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}};
  CHECK(read("fan.obj", points + "f 1 2 3 4 5\n").triangles == fan);
  CHECK(read("fan.obj", "f 1 2 3 4 5\n" + points).triangles == fan);  // vertices may follow
  CHECK(read("fan.obj", points + "f -5 -4 -3 -2 -1\n").triangles == fan);
  CHECK(read("fan.ply",
             "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 2 1 0 1 2 0 0 1 0\n"
             "5 0 1 2 3 4")
            .triangles == fan);
}

TEST_CASE("a surface file that is not what we read is refused with place, finding and what is allowed",
          "[surface][reader][refusal]") {
  const TriangleSurface sphere = octasphere(0, 1.0, {0, 0, 0});
  const std::string stl = text_stl(sphere), ply = text_ply(sphere);
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  struct Case {
    std::string name, contents, message;
  };
  const std::vector<Case> cases = {
      {"a.stl", "", "1: the file is empty"},
      {"a.stl", "solid\nendsolid\n", "2: text STL: found no facet, allowed one or more"},
      {"a.stl", replaced(stl, "outer", "inner"), "3: text STL: found \"inner\", allowed \"outer\""},
      {"a.stl", replaced(stl, "vertex 1", "vertex one"), "4: coordinate: found \"one\", allowed a finite number"},
      {"a.stl", replaced(stl, "vertex 1", "vertex inf"), "4: coordinate: found \"inf\", allowed a finite number"},
      {"a.stl", replaced(stl, "endsolid a sphere\n", ""), "58: endsolid: found the end of the file"},
      {"a.stl", binary_stl(sphere).substr(0, 400),
       " byte 80: number of triangles: found 8, which take 400 bytes, and 316 bytes after it, allowed as many as it "
       "announces"},
      {"a.stl", replaced(binary_stl(sphere), std::string("\0\0\x80\x3f", 4), std::string("\0\0\xc0\x7f", 4)),
       " byte 96: coordinate: found nan, allowed a finite number"},
      {"a.obj", points + "f 1 2 4\n", "4: corner of face: found vertex 4, allowed 1 to 3"},
      {"a.obj", points + "f 1 2 0\n",
       "4: corner of face: found \"0\", allowed a vertex from 1, or from -1 to -3 back from the last, and / after it"},
      {"a.obj", points + "f 1 2 -4\n",
       "4: corner of face: found \"-4\", allowed a vertex from 1, or from -1 to -3 back from the last, and / after it"},
      {"a.obj", points + "f 1 2\nf 1 2 3\n", "4: f: found 2 corners, allowed 3 or more"},
      {"a.obj", "v 0 0\n", "1: v: found 2 coordinates, allowed three"},
      {"a.obj", points, "3: OBJ: found no face, allowed one or more"},
      {"a.obj", points + "curv 0 1\n",
       "4: OBJ: found \"curv\", allowed v, f, comments and what is skipped: vt, vn, g, o, s, usemtl, mtllib, l, p and "
       "the like"},
      {"a.ply", replaced(ply, "ply\n", "plx\n"), "1: ply: found \"plx\", allowed \"ply\" at the start"},
      {"a.ply", replaced(ply, "ascii", "binary"),
       "2: format: found \"binary\", allowed ascii, binary_little_endian or binary_big_endian"},
      {"a.ply", replaced(ply, "1.0", "1.1"), "2: format version: found \"1.1\", allowed 1.0"},
      {"a.ply", replaced(ply, "double y", "double v"), "4: element vertex: found 0 properties y, allowed one"},
      {"a.ply", replaced(ply, "list uchar int vertex", "list float int vertex"),
       "12: length of list: found a type with decimals, allowed a whole type"},
      {"a.ply", replaced(ply, "face 8", "face 2000000000"),
       "21: element face: found 2000000000 announced, which take 8000000000 bytes or more, allowed what the 97 bytes "
       "left can hold"},
      {"a.ply", replaced(replaced(ply, "int view", "int v\x1b[2J"), "2 17 18", "x 17 18"),
       "21: v?[2J: found \"x\", allowed a whole number in [0, 2147483647]"},
      {"a.ply", replaced(ply, "face 8", "face 7"),
       "28: end of data: found more than the header announces, allowed nothing"},
      {"a.ply", replaced(ply, "3 0 1 2", "3 0 1 6"),
       "22: vertex_indices: found \"6\", allowed a whole number in [0, 5]"},
      {"a.ply", replaced(ply, "3 0 1 2", "2 0 1 2"),
       "22: corners of face: found \"2\", allowed a whole number in [3, 10000000]"},
      {"a.msh", gmsh(sphere, true).substr(0, 100), "12: $EndNodes: found the end of the file"},
      {"a.msh", replaced(gmsh(sphere, true), "1 2 2 0 1 5 15 25", "1 1 2 0 1 5 15"), "accepted"},
      {"a.msh", replaced(gmsh(sphere, true), "1 2 2 0 1 5 15 25", "1 3 2 0 1 5 15 25 35"),
       "15: element 1: found a quadrangle (3), allowed triangles (2)"},
      {"a.dat", points,
       "1: surface: found \"v 0 0 0 v 1 0 0 v 0 ...\", allowed STL, PLY or gmsh by content or extension (.stl, .ply, "
       ".msh), OBJ by extension (.obj)"},
  };
  for (const auto& [name, contents, message] : cases) {
    CAPTURE(name, contents.substr(0, 80));
    CHECK(refusal(name, contents) == message);
  }
}

TEST_CASE("no cut and no noise in a surface file does more than a refusal", "[surface][reader][refusal][fuzz]") {
  const TriangleSurface sphere = octasphere(1, 1.0, {0, 0, 0});
  const std::vector<std::pair<std::string, std::string>> files = {
      {"sphere.stl", text_stl(sphere)},
      {"sphere.stl", binary_stl(sphere)},
      {"sphere.obj", obj_text(sphere)},
      {"sphere.ply", text_ply(sphere)},
      {"sphere.ply", binary_ply<float, std::uint8_t, std::int32_t>(sphere, false, "uchar", "int")},
      {"sphere.msh", gmsh(sphere, false)}};
  std::mt19937 random(5);
  int refused = 0, tried = 0;
  for (const auto& [name, contents] : files)
    for (int round = 0; round < 120; ++round) {
      std::string broken = contents;
      if (round % 2 == 0) broken.resize(1 + random() % (broken.size() - 1));
      for (int k = 0; k < round % 4; ++k) broken[random() % broken.size()] = static_cast<char>(random() % 256);
      ++tried;
      refused += refusal(name, broken) != "accepted";
    }
  CAPTURE(refused, tried);
  CHECK(refused > tried / 2);  // a digit may become another
  CHECK(refused < tried);

  std::string noise(std::size_t{1} << 20, '\0');
  for (char& byte : noise) byte = static_cast<char>(random() % 256);
  for (const std::string name : {"n.stl", "n.obj", "n.ply", "n.msh", "n"}) CHECK(refusal(name, noise) != "accepted");
}
