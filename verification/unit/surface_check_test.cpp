#include "core/scene/surface_check.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "core/scene/scene_error.hpp"
#include "core/scene/surface_defects.hpp"
#include "core/scene/surface_intersections.hpp"
#include "core/scene/surface_shells.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/surface_samples.hpp"

using namespace finegauge;

namespace {

const std::string closed = "; allowed a closed surface, two triangles at every edge";

/// 32 triangles with corners such as (1, 0, 0) and (0.707106769, 0.707106769, 0), which single precision rounds.
TriangleSurface rounded_sphere() { return octasphere(1, 1.0, {0, 0, 0}); }

/// The message after the name; "accepted" where there is none.
std::string surface_refusal(const TriangleSurface& surface) {
  try {
    (void)check_surface(surface, "organ.stl");
  } catch (const SceneError& error) {
    const std::string message = error.what(), start = "organ.stl: surface: ";
    REQUIRE(message.rfind(start, 0) == 0);
    return message.substr(start.size());
  }
  return "accepted";
}

/// The first vertex of this place.
int vertex_at(const TriangleSurface& surface, const Eigen::Vector3d& x) {
  for (int v = 0; v < surface.vertices.cols(); ++v)
    if ((surface.vertices.col(v) - x).norm() < 1e-6) return v;
  FAIL("no vertex there");
  return -1;
}

/// A square [0, 1] × [0, 1] × [0, 1], two triangles a face.
TriangleSurface cube() {
  TriangleSurface surface;
  surface.vertices.resize(3, 8);
  for (int v = 0; v < 8; ++v) surface.vertices.col(v) = Eigen::Vector3d(v & 1, (v >> 1) & 1, v >> 2);
  for (const auto& [a, b, c, d] : std::vector<std::array<int, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    surface.triangles.push_back({a, b, c});
    surface.triangles.push_back({a, c, d});
  }
  return surface;
}

/// A prism over a circle of n corners; each cap is a fan around one of its corners.
TriangleSurface fan_prism(int n, double height) {
  TriangleSurface surface;
  surface.vertices.resize(3, 2 * n);
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / n;
    surface.vertices.col(i) = Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    surface.vertices.col(n + i) = Eigen::Vector3d(std::cos(angle), std::sin(angle), height);
    const int next = (i + 1) % n;
    surface.triangles.push_back({i, next, n + next});
    surface.triangles.push_back({i, n + next, n + i});
  }
  for (int i = 1; i + 1 < n; ++i) {
    surface.triangles.push_back({0, i + 1, i});
    surface.triangles.push_back({n, n + i, n + i + 1});
  }
  return surface;
}

/// Each with each, by the exact decision of a search that knows of these two alone.
std::vector<std::array<int, 2>> all_intersections(const TriangleSurface& surface) {
  std::vector<std::array<int, 2>> pairs;
  for (int a = 0; a < surface.triangle_count(); ++a)
    for (int b = a + 1; b < surface.triangle_count(); ++b) {
      const TriangleSurface two{
          surface.vertices,
          {surface.triangles[static_cast<std::size_t>(a)], surface.triangles[static_cast<std::size_t>(b)]}};
      if (!intersecting_triangles(two, 1).pairs.empty()) pairs.push_back({a, b});
    }
  return pairs;
}

}  // namespace

TEST_CASE("of fans of thousands few pairs are decided, in proportion to their triangles", "[surface][check]") {
  const double height = GENERATE(1.0, 1e-3);
  for (const int n : {500, 2000, 8000}) {
    CAPTURE(n, height);
    const TriangleSurface surface = fan_prism(n, height);
    const Intersections found = intersecting_triangles(surface, 10);
    CHECK(found.pairs.empty());
    // Each triangle of the wall has some dozen neighbours; each with each would be 4 n² pairs.
    CHECK(found.decided >= surface.triangles.size());
    CHECK(found.decided <= 25 * surface.triangles.size());
  }
  CHECK(check_surface(fan_prism(500, height), "").notes.empty());
}

TEST_CASE("intersections are those of each triangle with each, fans and slivers among them", "[surface][check]") {
  const int seed = GENERATE(range(1, 9));
  CAPTURE(seed);
  std::mt19937 generator(static_cast<unsigned>(seed));
  TriangleSurface surface = seed % 2 == 0 ? fan_prism(60, 0.02) : octasphere(2, 1.0, {0.3, 0, 0});
  // Vertices that leave their place, some along the rim, some across the body.
  std::uniform_real_distribution<double> shift(-1.0, 1.0);
  for (int v = 0; v < surface.vertices.cols(); ++v)
    if (generator() % 3 == 0)
      for (int axis = 0; axis < 3; ++axis) surface.vertices(axis, v) += (seed % 2 == 0 ? 0.1 : 0.6) * shift(generator);
  const std::vector<std::array<int, 2>> expected = all_intersections(surface);
  REQUIRE(!expected.empty());
  const Intersections found = intersecting_triangles(surface, 100000);
  CHECK(found.pairs == expected);
  CHECK(found.all);
  const Intersections some = intersecting_triangles(surface, expected.size() - 1);
  CHECK_FALSE(some.all);
  CHECK(some.pairs.size() == expected.size() - 1);
}

TEST_CASE("a sound surface passes unchanged and without a note", "[surface][check]") {
  const TriangleSurface given = octasphere(3, 0.1, {5.0, 0.0, -2.0});
  const CheckedSurface checked = check_surface(given, "sphere");
  CHECK(checked.notes.empty());
  CHECK(checked.surface.vertices == given.vertices);
  CHECK(checked.surface.triangles == given.triangles);
}

TEST_CASE("repairs leave the surface in space as it is and say what they did", "[surface][check]") {
  const TriangleSurface sound = rounded_sphere();
  const double volume = volume_by_divergence(sound);
  using Notes = std::vector<std::string>;

  SECTION("vertices that no triangle uses, though they be nowhere") {
    TriangleSurface given = sound;
    given.vertices.resize(3, sound.vertices.cols() + 2);
    given.vertices.rightCols(2).setConstant(std::numeric_limits<double>::quiet_NaN());
    given.vertices.leftCols(sound.vertices.cols()) = sound.vertices;
    given.vertices.col(0).swap(given.vertices.col(19));
    for (auto& corners : given.triangles) std::replace(corners.begin(), corners.end(), 0, 19);
    const CheckedSurface checked = check_surface(given, "");
    CHECK(checked.notes == Notes{"dropped 2 vertices that no triangle uses"});
    CHECK(checked.surface.vertices.cols() == 18);
    CHECK(volume_by_divergence(checked.surface) == Approx(volume).epsilon(1e-14));
  }
  SECTION("corners of each triangle written anew, one with the other sign of zero") {
    TriangleSurface given;
    given.vertices.resize(3, 96);
    for (int i = 0; i < 96; ++i)
      given.vertices.col(i) = sound.vertices.col(sound.triangles[static_cast<std::size_t>(i / 3)][i % 3]);
    for (int i = 0; i < 96; i += 2)
      for (int axis = 0; axis < 3; ++axis)
        if (given.vertices(axis, i) == 0.0) given.vertices(axis, i) = -0.0;
    for (int i = 0; i < 96; i += 3) given.triangles.push_back({i, i + 1, i + 2});
    const CheckedSurface checked = check_surface(given, "");
    CHECK(checked.notes ==
          Notes{"merged 78 vertices that equal another exactly, the first at (0.707106769, 0.707106769, 0)"});
    CHECK(checked.surface.vertices == sound.vertices);
    CHECK(checked.surface.triangles == sound.triangles);
  }
  SECTION("triangles that name a vertex twice") {
    TriangleSurface given = sound;
    const auto [a, b, c] = sound.triangles[7];
    given.triangles.insert(given.triangles.begin(), {{a, a, b}, {c, c, 18}, {18, 18, 18}});
    given.vertices.conservativeResize(Eigen::NoChange, 19);  // one that the dropped ones alone use
    given.vertices.col(18) = Eigen::Vector3d(0, 0, 7);
    const CheckedSurface checked = check_surface(given, "");
    CHECK(checked.notes == Notes{"dropped 3 triangles that name a vertex twice"});
    CHECK(checked.surface.triangles == sound.triangles);
    CHECK(checked.surface.vertices == sound.vertices);
  }
  SECTION("triangles without area, two of them side by side, where a neighbour's side has vertices") {
    // The diagonal 0 - 3 of the lower face of the cube with the vertices (1, 1)/4 and (1, 1)/2 on one of its sides.
    TriangleSurface given = cube();
    given.vertices.conservativeResize(Eigen::NoChange, 10);
    given.vertices.col(8) = Eigen::Vector3d(0.25, 0.25, 0);
    given.vertices.col(9) = Eigen::Vector3d(0.5, 0.5, 0);
    REQUIRE(given.triangles[1] == std::array{0, 3, 1});
    given.triangles[1] = {0, 8, 1};
    given.triangles.insert(given.triangles.end(), {{8, 9, 1}, {9, 3, 1}, {0, 3, 9}, {0, 9, 8}});
    const CheckedSurface checked = check_surface(given, "");
    REQUIRE(checked.notes.size() == 1);
    CHECK(checked.notes[0].find("of no area by splitting the neighbour at its long side") != std::string::npos);
    CHECK(checked.surface.vertices.cols() == 10);
    CHECK(checked.surface.triangles.size() == 16);
    CHECK(volume_by_divergence(checked.surface) == Approx(1.0).epsilon(1e-15));
    CHECK(check_surface(checked.surface, "").notes.empty());
  }
  SECTION("a surface inside out") {
    const CheckedSurface checked = check_surface(turned(sound), "");
    CHECK(checked.notes == Notes{"turned all triangles: the surface was inside out"});
    CHECK(volume_by_divergence(checked.surface) == Approx(volume).epsilon(1e-14));
  }
}

TEST_CASE("separate shells are bodies, or cavities where they are turned", "[surface][check]") {
  const TriangleSurface big = octasphere(2, 1.0, {0, 0, 0}), small = octasphere(1, 0.5, {0.1, 0, 0});
  const TriangleSurface inner = octasphere(1, 0.2, {0.1, 0, 0}), away = octasphere(1, 0.5, {3, 0, 0});
  const double hollow = volume_by_divergence(big) - volume_by_divergence(small);
  using Notes = std::vector<std::string>;

  SECTION("two bodies") {
    const CheckedSurface checked = check_surface(together(big, away), "");
    CHECK(checked.notes == Notes{"found 2 separate shells, 0 of them around cavities"});
    CHECK(volume_by_divergence(checked.surface) == Approx(volume_by_divergence(big) + volume_by_divergence(away)));
  }
  SECTION("two bodies, one inside out") {
    const CheckedSurface checked = check_surface(together(big, turned(away)), "");
    REQUIRE(checked.notes.size() == 2);
    CHECK(checked.notes[0].rfind("turned 1 shell of 2: inside out, the first with triangle 128 near (3.", 0) == 0);
    CHECK(volume_by_divergence(checked.surface) == Approx(volume_by_divergence(big) + volume_by_divergence(away)));
  }
  SECTION("a cavity, and a body in it") {
    const CheckedSurface checked = check_surface(together(together(turned(small), inner), big), "");
    CHECK(checked.notes == Notes{"found 3 separate shells, 1 of them around cavities"});
    CHECK(volume_by_divergence(checked.surface) == Approx(hollow + volume_by_divergence(inner)));
  }
  SECTION("a cavity, inside out as a whole") {
    const CheckedSurface checked = check_surface(together(turned(big), small), "");
    REQUIRE(checked.notes.size() == 2);
    CHECK(checked.notes[0] == "turned all triangles: the surface was inside out");
    CHECK(volume_by_divergence(checked.surface) == Approx(hollow));
  }
  SECTION("a shell in another of the same orientation says nothing") {
    const std::string found = surface_refusal(together(big, small));
    CHECK(found.rfind("found a shell inside 1 other that is turned as the one around it, with triangle 128 near (",
                      0) == 0);
  }
  SECTION("two bodies that touch at a vertex") {
    TriangleSurface touching = together(rounded_sphere(), rounded_sphere());
    touching.vertices.rightCols(18).row(0).array() += 2.0;
    const CheckedSurface checked = check_surface(touching, "");
    CHECK(checked.notes == Notes{"merged 1 vertex that equals another exactly, at (1, 0, 0)",
                                 "the surface touches itself at 1 vertex, the first at (1, 0, 0)",
                                 "found 2 separate shells, 0 of them around cavities"});
  }
}

TEST_CASE("a surface that bounds no volume is refused with what and where", "[surface][check][refusal]") {
  const TriangleSurface sound = rounded_sphere();
  TriangleSurface given = sound;

  SECTION("a triangle is missing") {
    REQUIRE(sound.triangles[0] == std::array{0, 1, 2});
    given.triangles.erase(given.triangles.begin());
    CHECK(
        surface_refusal(given) ==
        "found 3 open edges of one triangle: from (1, 0, 0) to (0.707106769, 0.707106769, 0) of triangle 16; from (1, "
        "0, 0) to (0.707106769, 0, 0.707106769) of triangle 12; from (0.707106769, 0.707106769, 0) to (0.707106769, 0, "
        "0.707106769) of triangle 2" +
            closed);
  }
  SECTION("a triangle is turned") {
    std::swap(given.triangles[0][1], given.triangles[0][2]);
    CHECK(
        surface_refusal(given) ==
        "found 3 edges whose two triangles run through it in the same direction (inconsistent orientation): from (1, "
        "0, "
        "0) to (0.707106769, 0.707106769, 0) of triangles 0 and 17; from (1, 0, 0) to (0.707106769, 0, 0.707106769) of "
        "triangles 0 and 13; from (0.707106769, 0.707106769, 0) to (0.707106769, 0, 0.707106769) of triangles 0 and 3; "
        "allowed opposite directions, all triangles counter-clockwise from outside");
  }
  SECTION("a triangle stands twice, once turned") {
    given.triangles.push_back({sound.triangles[5][1], sound.triangles[5][0], sound.triangles[5][2]});
    const auto place = [&](std::size_t k) { return point_words(sound.vertices.col(sound.triangles[5][k])); };
    CHECK(surface_refusal(given) == "found 1 triangle that repeats another: 5 and 32 at " + place(0) + ", " + place(1) +
                                        ", " + place(2) + "; allowed each once");
  }
  SECTION("a wall stands inside") {
    const int a = vertex_at(sound, {1, 0, 0}), b = vertex_at(sound, {0, 1, 0}), c = vertex_at(sound, {0, 0, 1});
    const int ab = vertex_at(sound, {std::sqrt(0.5), std::sqrt(0.5), 0});
    given.triangles.insert(given.triangles.end(), {{a, ab, c}, {ab, b, c}});
    CHECK(
        surface_refusal(given) ==
        "found 2 edges of three or more triangles (not a manifold): from (1, 0, 0) to (0.707106769, 0.707106769, 0) of "
        "triangles 0, 17, 32; from (0.707106769, 0.707106769, 0) to (0, 1, 0) of triangles 1, 16, 33" +
            closed);
  }
  SECTION("two spheres cross") {
    const std::string found = surface_refusal(together(sound, octasphere(1, 1.0, {1.3, 0.1, 0.2})));
    CAPTURE(found);
    CHECK(
        found.rfind("found 20 pairs of triangles that intersect (self-intersection): 1 near (0.235702256, 0.804737846, "
                    "0.235702256) and 52 near (0.495262166, 0.335702265, -0.0357022583); ",
                    0) == 0);
  }
  SECTION("a vertex is moved through the opposite side") {
    given.vertices.col(vertex_at(sound, {1, 0, 0})).x() = -1.5;
    const std::string found = surface_refusal(given);
    CAPTURE(found);
    CHECK(found.find("pairs of triangles that intersect (self-intersection): 0 near (") != std::string::npos);
  }
  SECTION("a fold lies flat in the plane of its neighbours") {
    TriangleSurface folded = cube();  // two vertices in the lower face, one of which lies in the fan of the other
    folded.vertices.conservativeResize(Eigen::NoChange, 10);
    folded.vertices.col(8) = Eigen::Vector3d(0.5, 0.5, 0.0);
    folded.vertices.col(9) = Eigen::Vector3d(0.75, 0.5, 0.0);
    folded.triangles.erase(folded.triangles.begin(), folded.triangles.begin() + 2);
    folded.triangles.insert(folded.triangles.end(), {{0, 2, 8}, {2, 3, 8}, {1, 0, 8}, {3, 1, 9}, {1, 8, 9}, {8, 3, 9}});
    CHECK(surface_refusal(folded) == "accepted");
    folded.vertices(0, 9) = 0.25;  // across vertex 8: pairs that share an edge, a vertex or nothing
    const std::string found = surface_refusal(folded);
    CAPTURE(found);
    CHECK(found.rfind(
              "found 9 pairs of triangles that intersect (self-intersection): 10 near (0.166666667, 0.5, 0) and 13 ",
              0) == 0);
  }
  SECTION("a vertex is not a number") {
    given.vertices(1, 4) = std::numeric_limits<double>::quiet_NaN();
    CHECK(surface_refusal(given) == "found vertex 4 at (0, nan, 0.707106769), allowed finite coordinates");
  }
  SECTION("there is next to nothing") {
    given.vertices *= 1e-200;
    CHECK(surface_refusal(given).rfind("found coordinates up to 1e-200 over a diagonal of ", 0) == 0);
    CHECK(surface_refusal(TriangleSurface{Eigen::Matrix3Xd(3, 0), {}}) ==
          "found no triangle, allowed a closed surface");
    const int only = 0;
    given.triangles = {{only, only, only}};
    CHECK(surface_refusal(given).find("allowed") != std::string::npos);
  }
  SECTION("a triangle without area has no neighbour at its long side") {
    given.vertices.conservativeResize(Eigen::NoChange, 20);
    given.vertices.col(18) = Eigen::Vector3d(2, 0, 0);
    given.vertices.col(19) = Eigen::Vector3d(3, 0, 0);
    given.triangles.push_back({vertex_at(sound, {1, 0, 0}), 19, 18});
    CHECK(
        surface_refusal(given) ==
        "found 1 triangle of no area whose vertices differ, at whose long side there is no single neighbour to split: "
        "32 near (2, 0, 0); allowed triangles with an area");
  }
}

TEST_CASE("vertices written more than once are merged when equal and called slits when nearly so",
          "[surface][check][refusal]") {
  TriangleSurface given = rounded_sphere();
  const int vertex = given.triangles[0][1];
  given.vertices.conservativeResize(Eigen::NoChange, 19);
  given.vertices.col(18) = given.vertices.col(vertex);
  given.triangles[0][1] = 18;
  CHECK(check_surface(given, "").notes ==
        std::vector<std::string>{"merged 1 vertex that equals another exactly, at (0.707106769, 0.707106769, 0)"});

  given.vertices(2, 18) += 1e-7;
  const std::string slits = surface_refusal(given);
  CAPTURE(slits);
  CHECK(slits.rfind("found 4 open edges of one triangle: ", 0) == 0);
  CHECK(slits.find("; 4 of them are slits: their ends coincide with those of another open edge within 1e-6 of the "
                   "diagonal, the first is from (1, 0, 0) to (0.707106769, 0.707106769, 0) and from (1, 0, 0) to "
                   "(0.707106769, 0.707106769, 1e-07): vertices written more than once") != std::string::npos);

  given.vertices(2, 18) += 1e-3;
  const std::string gap = surface_refusal(given);
  CHECK(gap.rfind("found 4 open edges of one triangle: ", 0) == 0);
  CHECK(gap.find("slits") == std::string::npos);
}

TEST_CASE("a slit is found whichever way its vertices are apart, up to 1e-6 of the diagonal", "[surface][check]") {
  const TriangleSurface sound = rounded_sphere();
  const double diagonal = 2.0 * std::sqrt(3.0);
  for (int way = 0; way < 27; ++way) {
    const Eigen::Vector3d apart = Eigen::Vector3i(way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1).cast<double>();
    if (apart.norm() == 0.0) continue;
    for (const double share : {0.98e-6, 1.02e-6}) {
      TriangleSurface given = sound;
      given.vertices.conservativeResize(Eigen::NoChange, 19);
      given.vertices.col(18) = sound.vertices.col(sound.triangles[0][1]) + share * diagonal * apart.normalized();
      given.triangles[0][1] = 18;
      const std::string found = surface_refusal(given);
      CAPTURE(apart.transpose(), share, found);
      CHECK(found.rfind("found 4 open edges", 0) == 0);
      CHECK((found.find("; 4 of them are slits") != std::string::npos) == (share < 1e-6));
    }
  }
}

TEST_CASE("a surface winds once around what it encloses, close to it as well", "[surface][check]") {
  const TriangleSurface shell = octasphere(2, 1.0, {0, 0, 0}), both = together(shell, octasphere(1, 2.0, {0, 0, 0}));
  std::vector<int> all, outer;
  for (int t = 0; t < static_cast<int>(both.triangles.size()); ++t) {
    all.push_back(t);
    if (t >= 128) outer.push_back(t);
  }
  const std::vector<int> inner(all.begin(), all.begin() + 128);
  for (const auto& corners : shell.triangles) {
    const Eigen::Vector3d a = shell.vertices.col(corners[0]), b = shell.vertices.col(corners[1]);
    const Eigen::Vector3d c = shell.vertices.col(corners[2]);
    for (const Eigen::Vector3d& on : {a, Eigen::Vector3d((a + b) / 2), Eigen::Vector3d((a + b + c) / 3)}) {
      CHECK(winding_number(both, inner, (1.0 - 1e-9) * on) == 1);
      CHECK(winding_number(both, inner, (1.0 + 1e-9) * on) == 0);
      CHECK(winding_number(both, all, (1.0 - 1e-9) * on) == 2);
      CHECK(winding_number(both, outer, (1.0 + 1e-9) * on) == 1);
    }
  }
  CHECK(winding_number(turned(both), inner, {0.3, -0.2, 0.1}) == -1);
}

TEST_CASE("a broken surface scaled by a power of two is refused in the same words", "[surface][check]") {
  TriangleSurface crossing = together(octasphere(2, 1.0, {0, 0, 0}), octasphere(2, 1.0, {1.3, 0.1, 0.2}));
  const auto until_place = [](const std::string& words) { return words.substr(0, words.find(" near ")); };
  const std::string found = surface_refusal(crossing);
  REQUIRE(found != "accepted");
  for (const double scale : {0x1p-30, 0x1p30}) {
    TriangleSurface scaled = crossing;
    scaled.vertices *= scale;
    CHECK(until_place(surface_refusal(scaled)) == until_place(found));
  }
}
