#include "core/mesh/triangle_surface.hpp"

#include <map>
#include <numbers>

#include "verification/support/catch.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/convergence.hpp"
#include "verification/support/surface_samples.hpp"

using namespace finegauge;
using Eigen::Vector3d;

namespace {
using std::numbers::pi;
}

TEST_CASE("the surfaces of the tests are closed: each edge is walked once in each direction", "[surface]") {
  const std::array<TriangleSurface, 6> surfaces = {
      icosphere(1),
      icosphere(5),
      closed_box({1, 2, 3}, {0, 0, 0}, oblique_turn(), 3),
      closed_torus(2.0, 0.5, 7, 5),
      closed_tetrahedron({Vector3d(0, 0, 0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}),
      closed_ellipsoid(4, {1, 2, 3})};
  for (const TriangleSurface& surface : surfaces) {
    std::map<std::array<int, 2>, int> walks;
    for (const auto& t : surface.triangles)
      for (int c = 0; c < 3; ++c) ++walks[{t[c], t[(c + 1) % 3]}];
    for (const auto& [edge, count] : walks) {
      CHECK(count == 1);
      CHECK(walks.contains({edge[1], edge[0]}));
    }
    CHECK_THAT(enclosed_volume(surface), WithinRel(volume_by_divergence(surface), 1e-12));  // sums of hundreds of terms
    CHECK(enclosed_volume(surface) > 0.0);
    const int edges = static_cast<int>(walks.size()) / 2, genus = &surface == &surfaces[3] ? 1 : 0;
    CHECK(static_cast<int>(surface.vertices.cols()) - edges + surface.triangle_count() == 2 - 2 * genus);
  }
  CHECK(surfaces[1].triangle_count() == 20 * 25);
}

TEST_CASE("a box and a tetrahedron have their volume, area and centroid to round-off", "[surface]") {
  const Vector3d centre(0.3, -0.2, 0.7);
  const TriangleSurface box = closed_box({1.0, 0.5, 0.25}, centre, oblique_turn(), 3);
  const EnclosedSolid solid = enclosed_solid(box);
  CHECK_THAT(solid.volume, WithinRel(0.125, 1e-14));
  CHECK((solid.centroid - centre).norm() < 1e-15);
  CHECK_THAT(area(box), WithinRel(2.0 * (0.5 + 0.25 + 0.125), 1e-14));

  const std::array<Vector3d, 4> corners = {Vector3d(1, 1, 1), {1.5, 1, 1}, {1, 1.25, 1}, {1, 1, 2}};
  const EnclosedSolid tetrahedron = enclosed_solid(closed_tetrahedron(corners));
  CHECK_THAT(tetrahedron.volume, WithinRel(0.5 * 0.25 / 6.0, 1e-14));
  CHECK((tetrahedron.centroid - 0.25 * (corners[0] + corners[1] + corners[2] + corners[3])).norm() < 1e-15);
  const EnclosedSolid seen_from_inside = enclosed_solid(turned_inside_out(closed_tetrahedron(corners)));
  CHECK(seen_from_inside.volume == -tetrahedron.volume);
  CHECK((seen_from_inside.centroid - tetrahedron.centroid).norm() < 1e-15);
}

TEST_CASE("a body a kilometre away keeps its volume to what its coordinates hold", "[surface]") {
  // Coordinates near 1000 m are rounded by 1e-13 m each; edges of 0.1 m and a volume of 4e-3 m³ lose 1e-12 of theirs.
  // Tetrahedra to the far origin would lose another four digits.
  const TriangleSurface here = icosphere(6, 0.1);
  const TriangleSurface there = affine_image(Eigen::Matrix3d::Identity(), {1000.0, -800.0, 900.0}, here);
  CHECK_THAT(enclosed_volume(there), WithinRel(enclosed_volume(here), 1e-11));
  CHECK((enclosed_solid(there).centroid - Vector3d(1000.0, -800.0, 900.0)).norm() < 1e-12);
}

TEST_CASE("polyhedra in a sphere and a torus approach their volume by the square of the edge", "[surface]") {
  ErrorSeries sphere{"sphere", {}, {}}, ring{"torus", {}, {}}, sphere_area{"sphere's area", {}, {}};
  for (const int n : {4, 8, 16, 32}) {
    const TriangleSurface ball = icosphere(n, 2.0);
    sphere.h.push_back(1.0 / n);
    sphere.error.push_back(1.0 - enclosed_volume(ball) / (32.0 * pi / 3.0));
    sphere_area.h.push_back(1.0 / n);
    sphere_area.error.push_back(1.0 - area(ball) / (16.0 * pi));
    ring.h.push_back(1.0 / n);
    ring.error.push_back(1.0 - enclosed_volume(closed_torus(2.0, 0.5, 6 * n, 3 * n)) / (2.0 * pi * pi * 2.0 * 0.25));
  }
  // Inscribed, hence always too small; the next term is of fourth order.
  INFO(convergence_table({sphere, sphere_area, ring}));
  for (const ErrorSeries& series : {sphere, sphere_area, ring}) {
    CHECK_THAT(fitted_order(series), WithinAbs(2.0, 0.06));
    CHECK_THAT(last_order(series), WithinAbs(2.0, 0.02));
    CHECK(series.error.back() > 0.0);
    CHECK(series.error.back() < 2e-3);
  }
}

TEST_CASE("vertices that no triangle uses have no say in box, volume and centroid", "[surface]") {
  TriangleSurface surface = icosphere(3, 0.5, {1, 2, 3});
  const EnclosedSolid before = enclosed_solid(surface);
  const BoundingBox box = bounding_box(surface);
  surface.vertices.conservativeResize(3, surface.vertices.cols() + 1);
  surface.vertices.rightCols<1>() = Vector3d(100, 100, 100);
  CHECK(enclosed_solid(surface).volume == before.volume);
  CHECK(enclosed_solid(surface).centroid == before.centroid);
  CHECK(bounding_box(surface).upper == box.upper);
  CHECK((box.upper - box.lower).maxCoeff() <= 1.0);
  CHECK(enclosed_solid(TriangleSurface{}).volume == 0.0);
}
