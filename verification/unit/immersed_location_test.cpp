#include "core/mesh/immersed_location.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/mesh/body_location.hpp"
#include "core/mesh/immersed_body.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/deformed_body.hpp"

using namespace finegauge;

namespace {

/// A refined mesh around the surface, bent and turned; fields follow their masters at hanging nodes.
DeformedBody deformed(BaseMesh base, int refinements, std::mt19937& generator, double bend, double degrees = 170.0) {
  RefinementForest forest(std::move(base));
  const auto templates = all_templates();
  refine_randomly(forest, {templates, refinements, 3, 2000}, generator);
  Mesh mesh = forest.leaf_mesh();
  HangingNodes hanging = find_hanging_nodes(forest, mesh);
  Eigen::Matrix3Xd u = bent_and_turned(mesh, hanging, bend, degrees / 180.0 * std::numbers::pi);
  return {std::move(forest), std::move(mesh), std::move(hanging), std::move(u)};
}
BaseMesh immersed(const TriangleSurface& surface, double cell_size) {
  ImmersedMeshOptions options;
  options.cell_size.setConstant(cell_size);
  return immersed_mesh(surface, options);
}

std::optional<SurfaceHit> entry(const DeformedBody& body, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return first_body_entry(body.forest.base(), body.mesh, body.u, from, to);
}
std::optional<SurfaceHit> nearest(const DeformedBody& body, const Eigen::Vector3d& x, double reach) {
  return nearest_body_surface(body.forest.base(), body.mesh, body.u, x, reach);
}
bool inside(const DeformedBody& body, const Eigen::Vector3d& x) {
  return locate_in_body(body.forest.base(), body.mesh, body.u, x).has_value();
}
Eigen::Vector3d carried(const DeformedBody& body, const Eigen::Vector3d& X) {
  const auto point = locate_at_rest(body.forest.base(), X);
  REQUIRE(point);
  return X + interpolate(body.mesh, body.u, find_leaf(body.forest, body.mesh, *point));
}

/// The carried surface by brute force: every triangle cut into m² small flat ones, corners in the surface's sense.
std::vector<std::array<Eigen::Vector3d, 3>> small_triangles(const DeformedBody& body, int m) {
  const TriangleSurface& surface = body.forest.base().body->surface;
  std::vector<std::array<Eigen::Vector3d, 3>> all;
  for (const auto& triangle : surface.triangles) {
    std::array<Eigen::Vector3d, 3> rest;
    for (int c = 0; c < 3; ++c) rest[c] = surface.vertices.col(triangle[c]);
    std::vector<Eigen::Vector3d> points;
    const auto number = [&](int i, int j) { return i * (m + 1) - i * (i - 1) / 2 + j; };
    for (int i = 0; i <= m; ++i)
      for (int j = 0; j <= m - i; ++j)
        points.push_back(carried(body, ((m - i - j) * rest[0] + i * rest[1] + j * rest[2]) / m));
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < m - i; ++j) {
        all.push_back({points[number(i, j)], points[number(i + 1, j)], points[number(i, j + 1)]});
        if (j + 1 < m - i)
          all.push_back({points[number(i + 1, j)], points[number(i + 1, j + 1)], points[number(i, j + 1)]});
      }
  }
  return all;
}

struct Crossing {
  double fraction;
  double steepness;  ///< sine of the angle between segment and surface, > 0 where it enters
};
std::vector<Crossing> crossings(const std::vector<std::array<Eigen::Vector3d, 3>>& surface, const Eigen::Vector3d& from,
                                const Eigen::Vector3d& to) {
  std::vector<Crossing> found;
  const Eigen::Vector3d d = to - from;
  for (const auto& [a, b, c] : surface) {
    Eigen::Matrix3d A;
    A << b - a, c - a, -d;
    const Eigen::Vector3d at = A.fullPivLu().solve(from - a);
    if (!(at[0] >= 0.0 && at[1] >= 0.0 && at[0] + at[1] <= 1.0 && at[2] >= 0.0 && at[2] <= 1.0)) continue;
    found.push_back({at[2], -(b - a).cross(c - a).normalized().dot(d.normalized())});
  }
  std::sort(found.begin(), found.end(), [](const Crossing& p, const Crossing& q) { return p.fraction < q.fraction; });
  return found;
}

/// Bodies of the tests: smooth, with a hole, with edges across the lattice; about the size of one.
TriangleSurface sample_surface(int which) {
  if (which == 0) return icosphere(3, 0.6, {0.01, -0.02, 0.03});
  if (which == 1) return closed_torus(0.5, 0.2, 14, 8);
  return closed_box({1.1, 0.7, 0.6}, {0.02, 0.01, 0.0}, oblique_turn());
}

}  // namespace

TEST_CASE("a segment enters the carried surface where a fine triangulation says so", "[immersed][surface]") {
  const int which = GENERATE(0, 1, 2);
  const unsigned seed = GENERATE(1u, 2u);
  CAPTURE(which, seed);
  std::mt19937 generator(seed);
  const DeformedBody body = deformed(immersed(sample_surface(which), 0.3), 12, generator, 0.3);
  REQUIRE(body.hanging.hanging_count() > 50);
  REQUIRE(least_stretch(body.mesh, body.u) > 0.0);
  // Small triangles of 1/40 are off the curved surface by their square times its curvature, of the size of one.
  const auto surface = small_triangles(body, which == 2 ? 40 : 10);
  const Eigen::Matrix3Xd positions = body.positions();
  int entered = 0, missed = 0;
  double fraction_error = 0.0, position_error = 0.0, off_segment = 0.0;
  for (int k = 0; k < 80; ++k) {
    const Eigen::Vector3d middle = interpolate(body.mesh, positions, random_leaf_point(body.mesh, generator));
    const Eigen::Vector3d from = middle + 2.0 * random_vector(generator), to = middle + random_vector(generator);
    const auto all = crossings(surface, from, to);
    bool clear = true;  // of grazing and of ends on the surface, which small triangles cannot decide
    for (const Crossing& crossing : all)
      clear = clear && std::abs(crossing.steepness) > 0.15 && std::abs(crossing.fraction - 0.5) < 0.49;
    if (!clear) continue;
    const auto hit = entry(body, from, to);
    const auto first = std::find_if(all.begin(), all.end(), [](const Crossing& c) { return c.steepness > 0.0; });
    CHECK(hit.has_value() == (first != all.end()));
    missed += !hit;
    if (!hit || first == all.end()) continue;
    ++entered;
    const double length = (to - from).norm();
    fraction_error = std::max(fraction_error, std::abs(hit->fraction - first->fraction) * length * first->steepness);
    off_segment = std::max(off_segment, (hit->position - (from + hit->fraction * (to - from))).norm());
    position_error = std::max(
        position_error,
        (interpolate(body.mesh, positions, find_leaf(body.forest, body.mesh, hit->point)) - hit->position).norm());
    CHECK_THAT(hit->inward.norm(), WithinAbs(1.0, 1e-14));
    // A small triangle across a kink between leaves has a normal between theirs.
    CHECK_THAT(hit->inward.dot((to - from).normalized()), WithinAbs(first->steepness, 0.1));
    CHECK(inside(body, hit->position + 1e-6 * hit->inward));
    CHECK_FALSE(inside(body, hit->position - 1e-6 * hit->inward));
  }
  CHECK(entered > 15);
  CHECK(missed > 2);
  CHECK(fraction_error < 1e-3);
  // The material point is where the hit is: twice round-off of positions up to 3.
  CHECK_THAT(position_error, WithinAbs(0.0, 1e-14));
  CHECK_THAT(off_segment, WithinAbs(0.0, 1e-14));
}

TEST_CASE("a box that fills its cells has the surface of its cells", "[immersed][surface]") {
  // Two triangles a side, however many cells: what they cross bends with the cells. The faces of the cells are the
  // oracle, by code of its own.
  // Turned, or with faces along the axes, where boxes around pieces are thin.
  const unsigned seed = GENERATE(1u, 2u, 3u);
  const double degrees = GENERATE(0.0, 170.0);
  const bool sideways_first = GENERATE(false, true);  // two sets of segments
  CAPTURE(seed, degrees, sideways_first);
  std::mt19937 generator(seed);
  const DeformedBody body = deformed(immersed(closed_box({1.5, 1.0, 1.0}), 0.5), 8, generator, 0.35, degrees);
  REQUIRE(body.forest.base().cells.size() == 12);
  REQUIRE(body.hanging.hanging_count() > 20);
  int entered = 0, found_again = 0, flat = 0;
  double fraction_error = 0.0, normal_error = 0.0, place_error = 0.0;
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector3d middle = interpolate(body.mesh, body.positions(), random_leaf_point(body.mesh, generator));
    const Eigen::Vector3d from = middle + 2.0 * random_vector(generator), to = middle + random_vector(generator);
    const auto hit = entry(body, from, to), expected = first_entry(body.mesh, body.u, from, to);
    CHECK(hit.has_value() == expected.has_value());
    if (hit && expected) {
      ++entered;
      fraction_error = std::max(fraction_error, std::abs(hit->fraction - expected->fraction));
      const Eigen::Vector3d little = 1e-5 * (to - from).normalized();
      found_again += entry(body, hit->position - little, hit->position + little).has_value();
      normal_error = std::max(normal_error, (hit->inward - expected->inward).norm());
      place_error = std::max(
          place_error,
          (rest_position(body.forest.base(), hit->point) - rest_position(body.forest.base(), expected->point)).norm());
    }
    const auto near = nearest(body, to, 10.0), oracle = nearest_surface_point(body.mesh, body.u, to, 10.0);
    REQUIRE(near);
    REQUIRE(oracle);
    const double distance = (near->position - to).norm(), expected_distance = (oracle->position - to).norm();
    CAPTURE(to.transpose(), distance, expected_distance, near->position.transpose(), oracle->position.transpose(),
            rest_position(body.forest.base(), near->point).transpose(),
            rest_position(body.forest.base(), oracle->point).transpose());
    CHECK_THAT(distance, WithinAbs(expected_distance, 1e-13));
    CHECK(locate_deformed(body.mesh, body.u, to).has_value() == inside(body, to));
    // Nearly along the surface, which bends through the segment: in and out again, often in one piece.
    const Eigen::Vector3d& n = near->inward;
    // One after the other: within an expression each compiler would draw them in an order of its own.
    double tilt = 0.0;
    if (!sideways_first) tilt = 0.05 * random_number(generator);
    const Eigen::Vector3d sideways = random_vector(generator);
    if (sideways_first) tilt = 0.05 * random_number(generator);
    const Eigen::Vector3d along = sideways.cross(n).normalized() + tilt * n;
    const Eigen::Vector3d start = near->position - 0.4 * along + 0.005 * random_number(generator) * n;
    const auto grazing = entry(body, start, start + 0.8 * along);
    const auto expected_grazing = first_entry(body.mesh, body.u, start, start + 0.8 * along);
    CAPTURE(start.transpose(), along.transpose(), grazing ? grazing->fraction : -1.0,
            expected_grazing ? expected_grazing->fraction : -1.0,
            expected_grazing ? expected_grazing->inward.dot(along) : 0.0);
    CHECK(grazing.has_value() == expected_grazing.has_value());
    if (!grazing || !expected_grazing) continue;
    ++flat;
    CHECK_THAT(grazing->fraction, WithinAbs(expected_grazing->fraction, 1e-9));
  }
  CHECK(entered > 80);
  CHECK(found_again == entered);
  CHECK(flat > 80);
  // Round-off over the sine of the angle of the flattest hit.
  CHECK(fraction_error < 1e-12);
  CHECK(normal_error < 1e-12);
  CHECK(place_error < 1e-12);
}

TEST_CASE("a segment that grazes the surface enters it, however little of it there is inside", "[immersed][surface]") {
  // Under a place of a cell's face, along a direction in which the face bends away: inside for angle / curvature to
  // both sides of the place, if that is within the face; twice as far off, nothing is inside.
  const unsigned seed = GENERATE(1u, 2u, 3u);
  const double degrees = GENERATE(0.0, 170.0);
  const double angle = GENERATE(1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6);  // sine at which it enters
  CAPTURE(seed, degrees, angle);
  std::mt19937 generator(seed);
  const DeformedBody body = deformed(immersed(closed_box({1.5, 1.0, 1.0}), 0.5), 8, generator, 0.35, degrees);
  const Eigen::Matrix3Xd positions = body.positions();
  int tried = 0, missed = 0, missed_by_faces = 0, above = 0;
  double fraction_error = 0.0, steepness_error = 0.0;
  while (tried < 100) {
    const BoundaryFace& face = body.mesh.boundary[generator() % body.mesh.boundary.size()];
    const int axis = face.face / 2, first = (axis + 1) % 3, second = (axis + 2) % 3;
    LeafPoint leaf{face.cell, Eigen::Vector3d::Zero()};
    leaf.xi[axis] = face.face % 2;
    leaf.xi[first] = 0.5 + 0.3 * random_number(generator);
    leaf.xi[second] = 0.5 + 0.3 * random_number(generator);
    const double turn = std::numbers::pi * random_number(generator);
    // The face is bilinear: differences are derivatives.
    const auto at = [&](double a, double b) {
      LeafPoint moved = leaf;
      moved.xi[first] += a, moved.xi[second] += b;
      return interpolate(body.mesh, positions, moved);
    };
    const double h = 0.1;
    const Eigen::Vector3d place = at(0.0, 0.0), along_a = (at(h, 0.0) - place) / h, along_b = (at(0.0, h) - place) / h;
    const Eigen::Vector3d twist = (at(h, h) - at(h, 0.0) - at(0.0, h) + place) / (h * h);
    Eigen::Vector3d n = along_a.cross(along_b).normalized();
    if (face.face % 2) n = -n;
    const double a = std::copysign(std::cos(turn), std::sin(turn) * twist.dot(n)), b = std::sin(turn);
    const Eigen::Vector3d way = a * along_a + b * along_b;
    const double curvature = 2.0 * a * b * twist.dot(n) / way.squaredNorm(), reach = angle / curvature;
    const double size = std::min(along_a.norm(), along_b.norm());
    if (!(curvature > 0.02 && reach < 0.05 * size)) continue;
    ++tried;
    const double half = 0.15 * size, depth = 0.5 * angle * reach;
    const Eigen::Vector3d d = half * way.normalized(), middle = place + depth * n;
    const auto hit = entry(body, middle - d, middle + d),
               by_faces = first_entry(body.mesh, body.u, middle - d, middle + d);
    // Twice: once to the other side, where the answer comes from the other of the two places.
    missed += !hit || !entry(body, middle + d, middle - d);
    missed_by_faces += !by_faces;
    const Eigen::Vector3d off = place - depth * n;
    above += entry(body, off - d, off + d).has_value() + entry(body, off + d, off - d).has_value();
    if (!hit || !by_faces) continue;
    fraction_error = std::max(fraction_error, std::abs(hit->fraction - by_faces->fraction) * half);
    steepness_error = std::max(steepness_error, std::abs(hit->inward.dot(d) / half - angle));
  }
  CAPTURE(fraction_error, steepness_error);
  CHECK(missed == 0);
  CHECK(missed_by_faces == 0);
  CHECK(above == 0);
  // Round-off of positions up to 3 over the sine; at most 1 % of the angle is seen of the change of curvature.
  CHECK(fraction_error < 2e-15 / angle);
  CHECK(steepness_error < 0.03 * angle);
}

TEST_CASE("between a point outside and one inside a segment enters, wherever it runs", "[immersed][surface]") {
  // Membership is the oracle, by code that knows no surface: chords nearly along the surface, just below it, or nearly
  // along the straight lines in it. Three bodies that cut their cells, and one that fills them and has their faces too.
  const int which = GENERATE(0, 1, 2, 3);
  CAPTURE(which);
  std::mt19937 generator(11);
  const DeformedBody body = which < 3 ? deformed(immersed(sample_surface(which), 0.3), 10, generator, 0.3)
                                      : deformed(immersed(closed_box({1.5, 1.0, 1.0}), 0.5), 8, generator, 0.35);
  const Eigen::Matrix3Xd positions = body.positions();
  int brackets = 0, flat = 0, lost = 0, early = 0;
  for (int k = 0; k < 120; ++k) {
    const auto under = nearest(body, interpolate(body.mesh, positions, random_leaf_point(body.mesh, generator)), 10.0);
    REQUIRE(under);
    const double depth = std::pow(10.0, -4.5 + 1.5 * random_number(generator));
    const Eigen::Vector3d middle = under->position + depth * under->inward;
    const Eigen::Vector3d random = random_vector(generator);
    Eigen::Vector3d way = random.cross(under->inward).normalized();
    if (k % 2) {
      LeafPoint lower = find_leaf(body.forest, body.mesh, under->point), upper = lower;
      const int axis = k / 2 % 3;
      lower.xi[axis] = 0.0, upper.xi[axis] = 1.0;
      way = interpolate(body.mesh, positions, upper) - interpolate(body.mesh, positions, lower);
      way = way.normalized() + 1e-3 * random;
    }
    if (!inside(body, middle)) continue;  // at an edge
    for (double share = 0.3; share > 1e-4; share *= 0.5) {
      const Eigen::Vector3d from = middle - share * way;
      if (inside(body, from)) continue;
      ++brackets;
      const auto check = [&](const std::optional<SurfaceHit>& hit) {
        lost += !hit;
        if (!hit) return;
        const double steepness = hit->inward.dot(way.normalized());
        flat += steepness < 0.01;
        // Before it nothing is inside.
        const double before = std::max(0.0, hit->fraction - 1e-7 / (share * steepness));
        early += inside(body, from + before * (middle - from));
      };
      check(entry(body, from, middle));
      if (which == 3) check(first_entry(body.mesh, body.u, from, middle));
    }
  }
  CAPTURE(brackets, flat);
  CHECK(lost == 0);
  CHECK(early == 0);
  CHECK(brackets > 200);
  CHECK(flat > 20);
}

TEST_CASE("no segment slips between triangles or leaves, and none enters twice", "[immersed][surface]") {
  // Aimed at vertices and edges of the triangles, and at where the surface crosses planes of the lattice.
  std::mt19937 generator(5);
  const DeformedBody body = deformed(immersed(icosphere(3, 0.6), 0.3), 15, generator, 0.2);
  const TriangleSurface& surface = body.forest.base().body->surface;
  std::vector<Eigen::Vector3d> targets;
  for (const auto& triangle : surface.triangles) {
    std::array<Eigen::Vector3d, 3> X;
    for (int c = 0; c < 3; ++c) X[c] = surface.vertices.col(triangle[c]);
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d &a = X[c], &b = X[(c + 1) % 3];
      targets.push_back(a);
      targets.push_back(0.5 * (a + b));
      for (int axis = 0; axis < 3; ++axis) {
        const double plane = 0.15 * std::round(std::max(a[axis], b[axis]) / 0.15 - 0.5);
        const double share = (plane - a[axis]) / (b[axis] - a[axis]);
        if (!(share > 0.0 && share < 1.0)) continue;
        targets.push_back(a + share * (b - a));  // an edge on a plane of leaves
        for (const double off : {-2e-9, 2e-9})   // beside it, within the slack of both sides
          targets.push_back(a + (share + off) * (b - a));
        targets.push_back(0.5 * (a + share * (b - a)) + 0.5 * (X[0] + X[1] + X[2]) / 3.0);
      }
    }
  }
  REQUIRE(targets.size() > 1500);
  double place_error = 0.0;
  int lost = 0, twice = 0, unlike = 0;
  for (const Eigen::Vector3d& X : targets) {
    const Eigen::Vector3d x = carried(body, X), inwards = (carried(body, 0.9 * X) - x).normalized();
    const auto hit = entry(body, x - 0.1 * inwards, x + 0.1 * inwards);
    lost += !hit || !entry(body, x - 0.1 * inwards, x) || !entry(body, x, x + 0.1 * inwards);
    if (!hit) continue;
    place_error = std::max(place_error, (hit->position - x).norm());
    twice += entry(body, x + 1e-7 * inwards, x + 0.1 * inwards).has_value();
    unlike += inside(body, x - 1e-7 * inwards) || !inside(body, x + 1e-7 * inwards);
  }
  CHECK(lost == 0);
  CHECK(twice == 0);
  CHECK(unlike == 0);
  CHECK_THAT(place_error, WithinAbs(0.0, 1e-13));
}

TEST_CASE("a way out of an immersed body is no entry, a way back in is one", "[immersed][surface]") {
  BaseMesh base = immersed(closed_torus(0.5, 0.2, 16, 8), 0.25);
  const RefinementForest forest(base);
  const Mesh mesh = forest.leaf_mesh();
  const Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  const auto find = [&](double a, double b) {
    return first_body_entry(base, mesh, u, {a, 0.01, 0.02}, {b, 0.01, 0.02});
  };
  CHECK_FALSE(find(-0.5, -0.1));    // out
  CHECK_FALSE(find(-0.55, -0.45));  // within
  CHECK_FALSE(find(-0.1, 0.1));     // in the hole
  CHECK_FALSE(find(-0.5, -0.5));
  CHECK_FALSE(find(-0.5, std::nan("")));
  const auto back = find(-0.5, 0.5), first = find(-1.0, 0.5);
  REQUIRE(back);
  REQUIRE(first);
  CHECK_THAT(back->position.x(), WithinAbs(0.3, 0.02));  // the polyhedron is inside of the torus
  CHECK_THAT(first->position.x(), WithinAbs(-0.7, 0.02));
  CHECK(back->inward.x() > 0.9);
}

TEST_CASE("the nearest point of the carried surface is that of a dense sample, and stationary", "[immersed][surface]") {
  const int which = GENERATE(0, 1, 2);
  CAPTURE(which);
  std::mt19937 generator(7);
  const DeformedBody body = deformed(immersed(sample_surface(which), 0.3), 10, generator, 0.3);
  const auto surface = small_triangles(body, which == 2 ? 60 : 12);
  double spacing = 0.0;
  for (const auto& [a, b, c] : surface) spacing = std::max({spacing, (b - a).norm(), (c - b).norm(), (a - c).norm()});
  const Eigen::Matrix3Xd positions = body.positions();
  double above = 0.0, below = 0.0, off_body = 0.0;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector3d x =
        interpolate(body.mesh, positions, random_leaf_point(body.mesh, generator)) + 0.5 * random_vector(generator);
    const auto hit = nearest(body, x, 10.0);
    REQUIRE(hit);
    const double distance = (hit->position - x).norm();
    double sampled = 1e300;
    for (const auto& corners : surface)
      for (const Eigen::Vector3d& corner : corners) sampled = std::min(sampled, (corner - x).norm());
    above = std::max(above, distance - sampled);
    below = std::max(below, (sampled - distance) / spacing);
    off_body = std::max(
        off_body,
        (interpolate(body.mesh, positions, find_leaf(body.forest, body.mesh, hit->point)) - hit->position).norm());
    CHECK_FALSE(nearest(body, x, (1.0 - 1e-9) * distance));
    CHECK(nearest(body, x, (1.0 + 1e-9) * distance));
    // Beyond the point on the way from x the body begins or ends.
    const Eigen::Vector3d way = (hit->position - x).normalized();
    const bool from_inside = inside(body, x);
    if (distance > 1e-3) CHECK(inside(body, x + (distance - 1e-7) * way) == from_inside);
  }
  CHECK(above < 1e-13);
  CHECK(below < 0.6);  // a triangle's middle from its nearest corner, over its longest edge: at most 0.58
  CHECK_THAT(off_body, WithinAbs(0.0, 1e-14));
}

TEST_CASE("what a chain of points meets is named: an end or a way in", "[immersed][surface]") {
  const bool with_body = GENERATE(true, false);
  CAPTURE(with_body);
  BoxMeshOptions options;
  options.size = {1.5, 1.0, 1.0};
  options.origin = {-0.75, -0.5, -0.5};
  options.cells = {3, 2, 2};
  const BaseMesh base = with_body ? immersed(closed_box({1.5, 1.0, 1.0}), 0.5) : box_mesh(options);
  const Mesh mesh = RefinementForest(base).leaf_mesh();
  const Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  const auto along_x = [&](const std::vector<double>& x, double first_y = 0.03) {
    Eigen::Matrix3Xd chain(3, static_cast<Eigen::Index>(x.size()));
    double y = first_y;
    for (std::size_t k = 0; k < x.size(); ++k, y = 0.5)
      chain.col(static_cast<Eigen::Index>(k)) = Eigen::Vector3d(x[k], first_y > 0.5 ? y : first_y, 0.1);
    return chain_meeting(base, mesh, u, chain);
  };
  CHECK_FALSE(along_x({-3.0, -2.0, -1.0}));
  CHECK_FALSE(along_x({-3.0, -2.0, -0.75 - 1e-6}));
  using Kind = ChainMeeting::Kind;
  const auto check = [](const std::optional<ChainMeeting>& found, Kind kind, int point, double x) {
    REQUIRE(found);
    CHECK(found->kind == kind);
    CHECK(found->point == point);
    CHECK_THAT(found->position.x(), WithinAbs(x, 1e-15));
  };
  check(along_x({-3.0, -2.0, -0.5}), Kind::inside, 2, -0.5);
  check(along_x({0.2, -2.0, -3.0}), Kind::inside, 0, 0.2);
  check(along_x({-3.0, -2.0, -0.75}), Kind::on_surface, 2, -0.75);
  check(along_x({-3.0, -2.0, -0.75 - 1e-10}), Kind::on_surface, 2, -0.75 - 1e-10);
  // Nodes on both sides and none in it.
  check(along_x({-2.0, -1.0, 1.0, 2.0}), Kind::enters, 1, -0.75);
  check(along_x({-2.0, 0.0, 2.0}), Kind::enters, 0, -0.75);
  // Past a face and onto another: the chord that ends there meets it.
  check(along_x({-2.0, 0.0, 2.0}, 0.9), Kind::enters, 0, 0.0);
}

TEST_CASE("a surface that bulges past the corners of its triangles is met where it bulges", "[immersed][surface]") {
  // One cell, its side x = 1 twisted into x = 1 + y z / 2 or x = 1 + y (1 - z) / 2: flat triangles would be elsewhere
  // by up to an eighth, and boxes around their corners have no thickness for one of the two.
  const bool turned = GENERATE(false, true);
  CAPTURE(turned);
  const BaseMesh base = immersed(closed_box({1.0, 1.0, 1.0}, {0.5, 0.5, 0.5}), 1.0);
  REQUIRE(base.cells.size() == 1);
  const Mesh mesh = RefinementForest(base).leaf_mesh();
  const auto twist = [&](double y, double z) { return 0.5 * y * (turned ? 1.0 - z : z); };
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  for (int node = 0; node < mesh.node_count(); ++node) u(0, node) = twist(mesh.nodes(1, node), mesh.nodes(2, node));
  for (const double y : {0.2, 0.45, 0.8})
    for (const double z : {0.25, 0.5, 0.7}) {
      CAPTURE(y, z);
      const Eigen::Vector3d expected(1.0 + twist(y, z), y, z), way(1e-3, 0.0, 0.0);
      const auto hit = first_body_entry(base, mesh, u, expected + way, expected - way);
      REQUIRE(hit);
      CHECK((hit->position - expected).norm() < 1e-14);
      CHECK((rest_position(base, hit->point) - Eigen::Vector3d(1.0, y, z)).norm() < 1e-14);
      const auto near = nearest_body_surface(base, mesh, u, expected, 1e-3);
      REQUIRE(near);
      CHECK((near->position - expected).norm() < 1e-14);
    }
}
