// first_entry and nearest_surface_point of core/mesh/point_location.hpp.

#include <cmath>
#include <limits>

#include "core/mesh/point_location.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/deformed_body.hpp"

using namespace finegauge;

namespace {

/// The current corners of a boundary face; for a triangle the fourth makes s + t d vanish.
std::array<Eigen::Vector3d, 4> face_corners_now(const DeformedBody& body, const BoundaryFace& face) {
  const auto& corners = face_corners(body.mesh.shape, face.face);
  std::array<Eigen::Vector3d, 4> p;
  for (int c = 0; c < face_corner_count(body.mesh.shape); ++c) {
    const int node = body.mesh.cells[face.cell][corners[c]];
    p[c] = body.mesh.nodes.col(node) + body.u.col(node);
  }
  if (body.mesh.shape == CellShape::tetrahedron) p[3] = p[1] + p[2] - p[0];
  return p;
}
Eigen::Vector3d on_face(const std::array<Eigen::Vector3d, 4>& p, double s, double t) {
  return (1.0 - t) * ((1.0 - s) * p[0] + s * p[1]) + t * ((1.0 - s) * p[2] + s * p[3]);
}

/// Brute force: the surface as m × m × 2 triangles a face, all crossings of the segment, ascending by fraction. The
/// sign of a crossing is that of the way in.
struct FaceCrossing {
  double fraction;
  double steepness;  ///< sine of the angle between segment and surface, > 0 where it enters
};
std::vector<FaceCrossing> crossings(const DeformedBody& body, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                    int m) {
  std::vector<FaceCrossing> found;
  const Eigen::Vector3d d = to - from;
  for (const BoundaryFace& face : body.mesh.boundary) {
    const auto p = face_corners_now(body, face);
    const Eigen::Vector3d inside =
        corner_values(body.mesh, face.cell, body.positions()).leftCols(corner_count(body.mesh.shape)).rowwise().mean();
    const int triangles = body.mesh.shape == CellShape::tetrahedron ? 1 : 2 * m * m;
    for (int k = 0; k < triangles; ++k) {
      std::array<Eigen::Vector3d, 3> corner = {p[0], p[1], p[2]};
      if (triangles > 1) {
        const int column = k / 2 % m, row = k / 2 / m;
        const double h = 1.0 / m, s = column * h, t = row * h;
        if (k % 2)
          corner = {on_face(p, s + h, t + h), on_face(p, s, t + h), on_face(p, s + h, t)};
        else
          corner = {on_face(p, s, t), on_face(p, s + h, t), on_face(p, s, t + h)};
      }
      Eigen::Matrix3d A;
      A << corner[1] - corner[0], corner[2] - corner[0], -d;
      const Eigen::Vector3d at = A.fullPivLu().solve(from - corner[0]);
      if (!(at[0] >= 0.0 && at[1] >= 0.0 && at[0] + at[1] <= 1.0 && at[2] >= 0.0 && at[2] <= 1.0)) continue;
      Eigen::Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
      if (normal.dot(inside - on_face(p, 1.0 / 3.0, 1.0 / 3.0)) < 0.0) normal = -normal;
      found.push_back({at[2], normal.dot(d.normalized())});
    }
  }
  std::sort(found.begin(), found.end(),
            [](const FaceCrossing& a, const FaceCrossing& b) { return a.fraction < b.fraction; });
  return found;
}

}  // namespace

TEST_CASE("a segment enters the deformed body where a fine triangulation says so", "[surface]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  const DeformedBody body = deformed_body(shape, 4, generator, 0.35);
  REQUIRE(least_stretch(body.mesh, body.u) > 0.0);
  const Eigen::Matrix3Xd positions = body.positions();
  int entered = 0, missed = 0;
  double fraction_error = 0.0, position_error = 0.0, off_segment = 0.0;
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector3d middle = interpolate(body.mesh, positions, random_leaf_point(body.mesh, generator));
    const Eigen::Vector3d from = middle + 3.0 * random_vector(generator), to = middle + random_vector(generator);
    const auto all = crossings(body, from, to, 12);
    // Leave out what the triangles cannot decide: grazing, ends on the surface.
    bool clear = true;
    for (const FaceCrossing& crossing : all)
      clear = clear && std::abs(crossing.steepness) > 0.1 && std::abs(crossing.fraction - 0.5) < 0.49;
    if (!clear) continue;
    const auto hit = first_entry(body.mesh, body.u, from, to);
    const auto first = std::find_if(all.begin(), all.end(), [](const FaceCrossing& c) { return c.steepness > 0.0; });
    CHECK(hit.has_value() == (first != all.end()));
    missed += !hit;
    if (!hit || first == all.end()) continue;
    ++entered;
    fraction_error = std::max(fraction_error, std::abs(hit->fraction - first->fraction) * first->steepness);
    off_segment = std::max(off_segment, (hit->position - (from + hit->fraction * (to - from))).norm());
    position_error = std::max(
        position_error,
        (interpolate(body.mesh, positions, find_leaf(body.forest, body.mesh, hit->point)) - hit->position).norm());
    CHECK_THAT(hit->inward.norm(), WithinAbs(1.0, 1e-14));
    CHECK_THAT(hit->inward.dot((to - from).normalized()), WithinAbs(first->steepness, 0.03));
    // The normal points into the body, and the point is on its boundary.
    CHECK(locate_deformed(body.mesh, body.u, hit->position + 1e-6 * hit->inward));
    CHECK_FALSE(locate_deformed(body.mesh, body.u, hit->position - 1e-6 * hit->inward));
  }
  CHECK(entered > 15);
  CHECK(missed > 2);
  // Triangles are off the patch by |d| / (8 · 12²), |d| about 0.3: 3e-4 of the unit; those of tetrahedra are exact.
  CHECK(fraction_error < (shape == CellShape::hexahedron ? 5e-4 : 1e-13));
  CHECK_THAT(position_error, WithinAbs(0.0, 1e-14));
  CHECK_THAT(off_segment, WithinAbs(0.0, 1e-14));
}

TEST_CASE("a needle through a node or along an edge of the surface enters once, as beside it", "[surface]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto angle = GENERATE(0.0, 0.7, 170.0 / 180.0 * std::numbers::pi);
  CAPTURE(static_cast<int>(shape), angle);
  std::mt19937 generator(3);
  BoxMeshOptions options;
  options.cells = {2, 3, 3};
  options.shape = shape;
  RefinementForest forest(scrambled(box_mesh(options), generator));
  const auto templates = all_templates(shape);
  refine_randomly(forest, {templates, 12, 3, 600}, generator);
  const Mesh mesh = forest.leaf_mesh();
  REQUIRE(find_hanging_nodes(forest, mesh).hanging_count() > 10);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(angle, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift(0.1, 0.7, -0.3);
  const Eigen::Matrix3Xd u = ((R - Eigen::Matrix3d::Identity()) * mesh.nodes).colwise() + shift;
  std::vector<Eigen::Vector3d> targets;  // on the plane x = 0: nodes, middles of edges and of faces
  const auto inner = [](const Eigen::Vector3d& X) {
    return X.x() == 0.0 && X.y() > 0.01 && X.y() < 0.99 && X.z() > 0.01 && X.z() < 0.99;
  };
  for (const BoundaryFace& face : mesh.boundary)
    for (int a = 0; a < face_corner_count(shape); ++a)
      for (int b = 0; b <= a; ++b) {
        const auto& corners = face_corners(shape, face.face);
        const Eigen::Vector3d X = 0.5 * (mesh.nodes.col(mesh.cells[face.cell][corners[a]]) +
                                         mesh.nodes.col(mesh.cells[face.cell][corners[b]]));
        if (inner(X)) targets.push_back(X);
      }
  REQUIRE(targets.size() > 50);
  const auto current = [&](const Eigen::Vector3d& X) -> Eigen::Vector3d { return R * X + shift; };
  double fraction_error = 0.0, normal_error = 0.0, place_error = 0.0;
  for (const Eigen::Vector3d& X : targets) {
    // Straight, and slanted within the plane of an edge line.
    for (const Eigen::Vector3d& slant : {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.0, 0.2, 0.0)}) {
      const Eigen::Vector3d step = Eigen::Vector3d::UnitX() + slant;
      const auto hit = first_entry(mesh, u, current(X - 0.25 * step), current(X + 0.75 * step));
      REQUIRE(hit);
      fraction_error = std::max(fraction_error, std::abs(hit->fraction - 0.25));
      normal_error = std::max(normal_error, (hit->inward - R.col(0)).norm());
      place_error = std::max(place_error, (rest_position(forest.base(), hit->point) - X).norm());
      // Once: from just inside there is only the way out.
      CHECK_FALSE(first_entry(mesh, u, current(X + 1e-6 * step), current(X + 3.0 * step)));
      const Eigen::Vector3d beside(0.0, 3e-3, 2e-3);
      const auto near = first_entry(mesh, u, current(X + beside - 0.25 * step), current(X + beside + 0.75 * step));
      REQUIRE(near);
      fraction_error = std::max(fraction_error, std::abs(near->fraction - 0.25));
      normal_error = std::max(normal_error, (near->inward - R.col(0)).norm());
      // Ends on the surface: neither of two segments in a row may lose it.
      CHECK(first_entry(mesh, u, current(X - 0.25 * step), current(X)));
      CHECK(first_entry(mesh, u, current(X), current(X + 0.75 * step)));
    }
  }
  CHECK_THAT(fraction_error, WithinAbs(0.0, 1e-14));
  CHECK_THAT(normal_error, WithinAbs(0.0, 1e-13));
  CHECK_THAT(place_error, WithinAbs(0.0, 1e-14));
}

TEST_CASE("a way out is no entry, a way back in is one", "[surface]") {
  BoxMeshOptions options;
  options.cells = {3, 1, 2};
  options.size = {3.0, 1.0, 2.0};
  options.removed = RemovedBlock{{1, 0, 1}, {2, 1, 2}};  // a groove between two walls
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  options.shape = shape;
  const Mesh mesh = RefinementForest(box_mesh(options)).leaf_mesh();
  const Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  const double y = 0.4, z = 1.3;
  CHECK_FALSE(first_entry(mesh, u, {0.5, y, z}, {1.5, y, z}));
  CHECK_FALSE(first_entry(mesh, u, {0.5, y, z}, {0.7, y, z}));
  CHECK_FALSE(first_entry(mesh, u, {-1.0, y, z}, {-0.5, y, z}));
  CHECK_FALSE(first_entry(mesh, u, {-1.0, y, z}, {-1.0, y, z}));
  CHECK_FALSE(first_entry(mesh, u, {-1.0, y, z}, {std::nan(""), y, z}));
  const auto back = first_entry(mesh, u, {0.5, y, z}, {2.5, y, z});
  REQUIRE(back);
  CHECK_THAT(back->position.x(), WithinAbs(2.0, 1e-15));
  CHECK_THAT(back->fraction, WithinAbs(0.75, 1e-15));
  CHECK((back->inward - Eigen::Vector3d::UnitX()).norm() < 1e-15);
  const auto from_outside = first_entry(mesh, u, {-1.0, y, z}, {2.5, y, z});
  REQUIRE(from_outside);
  CHECK_THAT(from_outside->position.x(), WithinAbs(0.0, 1e-15));
  // Along the surface: neither in nor out.
  CHECK_FALSE(first_entry(mesh, u, {1.2, y, 1.0}, {1.8, y, 1.0}));
}

TEST_CASE("the nearest surface point is that of a dense sample, and stationary", "[surface]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(1u, 2u);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  const DeformedBody body = deformed_body(shape, 4, generator, 0.35);
  const Eigen::Matrix3Xd positions = body.positions();
  double above = 0.0, below = 0.0, oblique = 0.0, off_body = 0.0;
  int inside_a_face = 0;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector3d x =
        interpolate(body.mesh, positions, random_leaf_point(body.mesh, generator)) + random_vector(generator);
    const auto hit = nearest_surface_point(body.mesh, body.u, x, 10.0);
    REQUIRE(hit);
    const double distance = (hit->position - x).norm();
    double sampled = 1e300, spacing = 0.0;
    constexpr int m = 30;
    for (const BoundaryFace& face : body.mesh.boundary) {
      const auto p = face_corners_now(body, face);
      spacing = std::max({spacing, (p[1] - p[0]).norm() / m, (p[2] - p[0]).norm() / m, (p[3] - p[1]).norm() / m,
                          (p[3] - p[2]).norm() / m});
      for (int i = 0; i <= m; ++i)
        for (int j = 0; j <= (shape == CellShape::tetrahedron ? m - i : m); ++j)
          sampled = std::min(sampled, (on_face(p, i / double(m), j / double(m)) - x).norm());
    }
    above = std::max(above, distance - sampled);
    below = std::max(below, (sampled - distance) / spacing);
    off_body = std::max(
        off_body,
        (interpolate(body.mesh, positions, find_leaf(body.forest, body.mesh, hit->point)) - hit->position).norm());
    // Inside of a face the way to x is along the normal.
    const Eigen::Vector3d xi = find_leaf(body.forest, body.mesh, hit->point).xi;
    const std::array<double, 4> ends = {xi.x(), xi.y(), xi.z(), shape == CellShape::tetrahedron ? 1.0 - xi.sum() : 0.5};
    const auto on_end = [](double end) { return end < 1e-9 || end > 1.0 - 1e-9; };
    if (std::count_if(ends.begin(), ends.end(), on_end) == 1) {
      ++inside_a_face;
      oblique = std::max(oblique, (x - hit->position).cross(hit->inward).norm());
    }
    CHECK_FALSE(nearest_surface_point(body.mesh, body.u, x, (1.0 - 1e-9) * distance));
    CHECK(nearest_surface_point(body.mesh, body.u, x, (1.0 + 1e-9) * distance));
  }
  CHECK(inside_a_face > 10);
  CHECK(above < 1e-14);
  CHECK(below < 0.75);  // half a diagonal of the lattice
  CHECK_THAT(off_body, WithinAbs(0.0, 1e-14));
  CHECK_THAT(oblique, WithinAbs(0.0, 1e-13));
}
