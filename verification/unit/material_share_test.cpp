#include "core/mesh/material_share.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh/clipped_polygon.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/convergence.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;
using Eigen::Vector3d;

namespace {

using std::numbers::pi;

/// The points with normal · X <= offset.
struct PlaneSide {
  Vector3d normal;  ///< of length one
  double offset;
};

std::vector<PlaneSide> half_spaces(const TriangleSurface& convex) {
  std::vector<PlaneSide> found;
  for (int triangle = 0; triangle < convex.triangle_count(); ++triangle) {
    const Eigen::Matrix3d X = triangle_corners(convex, triangle);
    const Vector3d normal = (X.col(1) - X.col(0)).cross(X.col(2) - X.col(0)).normalized();
    const PlaneSide half{normal, normal.dot(X.col(0))};
    const auto same = [&](const PlaneSide& h) {
      return (h.normal - normal).norm() + std::abs(h.offset - half.offset) < 1e-9;
    };
    if (std::none_of(found.begin(), found.end(), same)) found.push_back(half);
  }
  return found;
}

/// Volume of an intersection of half-spaces, by brute force: its corners are the points where three planes meet and
/// that lie in all the others, and on each plane they span a convex face, the base of a pyramid.
double convex_volume(const std::vector<PlaneSide>& halves, const Vector3d& middle) {
  const int n = static_cast<int>(halves.size());
  std::vector<std::vector<Vector3d>> faces(halves.size());
  const auto add = [](std::vector<Vector3d>& face, const Vector3d& X) {
    const auto near = [&](const Vector3d& Y) { return (X - Y).norm() < 1e-11; };
    if (std::none_of(face.begin(), face.end(), near)) face.push_back(X);
  };
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b)
      for (int c = b + 1; c < n; ++c) {
        Eigen::Matrix3d A;
        A << halves[a].normal.transpose(), halves[b].normal.transpose(), halves[c].normal.transpose();
        if (std::abs(A.determinant()) < 1e-9) continue;
        const Vector3d X = A.inverse() * Vector3d(halves[a].offset, halves[b].offset, halves[c].offset);
        const auto holds = [&](const PlaneSide& h) { return h.normal.dot(X) <= h.offset + 1e-12; };
        if (!std::all_of(halves.begin(), halves.end(), holds)) continue;
        for (const int plane : {a, b, c}) add(faces[plane], X);
      }
  double volume = 0.0;
  for (int plane = 0; plane < n; ++plane) {
    auto& face = faces[plane];
    if (face.size() < 3) continue;
    Vector3d centre = Vector3d::Zero();
    for (const Vector3d& X : face) centre += X / static_cast<double>(face.size());
    const Vector3d s = (face[0] - centre).normalized(), t = halves[plane].normal.cross(s);
    const auto angle = [&](const Vector3d& X) { return std::atan2(t.dot(X - centre), s.dot(X - centre)); };
    std::sort(face.begin(), face.end(), [&](const Vector3d& X, const Vector3d& Y) { return angle(X) < angle(Y); });
    for (std::size_t k = 0; k < face.size(); ++k)
      volume += (face[k] - centre).cross(face[(k + 1) % face.size()] - centre).norm() / 6.0 *
                (halves[plane].offset - halves[plane].normal.dot(middle));
  }
  return volume;
}

/// The smaller box of which each side runs between two random places of the unit cell.
BoundingBox random_box(const Vector3d& corner, std::mt19937& generator) {
  BoundingBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = random_number(generator), length = 0.05 + 0.95 * (0.5 + 0.5 * random_number(generator));
    box.lower[axis] = corner[axis] + (0.5 + 0.5 * a) * (1.0 - length);
    box.upper[axis] = std::min(corner[axis] + 1.0, box.lower[axis] + length);
  }
  return box;
}

struct NamedSurface {
  const char* name;
  TriangleSurface surface;
};

std::vector<NamedSurface> bodies() {
  return {{"sphere", icosphere(12, 0.07, {0.01, -0.02, 0.03})},
          {"ellipsoid", closed_ellipsoid(10, {0.09, 0.05, 0.03}, {0.2, 0.1, -0.1})},
          {"turned box", closed_box({0.12, 0.07, 0.05}, {0.03, 0.01, -0.04}, oblique_turn())},
          {"torus", affine_image(oblique_turn(), {0.02, 0.03, 0.05}, closed_torus(0.06, 0.02, 40, 24))}};
}

double material_volume(const ImmersedBody& body) {
  double sum = 0.0;
  for (const double share : body.share) sum += share;
  return sum * body.cell_size.prod();
}

/// In the lattice cells with too little material for a base cell.
double left_out_volume(const ImmersedBody& body) {
  double sum = 0.0;
  for (int k = 0; k < body.lattice_cells[2]; ++k)
    for (int j = 0; j < body.lattice_cells[1]; ++j)
      for (int i = 0; i < body.lattice_cells[0]; ++i) {
        const double share = integrated_share(body, {Vector3d(i, j, k), Vector3d(i + 1, j + 1, k + 1)});
        if (share <= least_base_share) sum += share;
      }
  return sum * body.cell_size.prod();
}

}  // namespace

TEST_CASE("shares of base cells add up to the enclosed volume", "[immersed][share]") {
  for (const auto& [name, surface] : bodies())
    for (const double h : {0.03, 0.017, 0.0061})
      for (const Vector3d& offset : {Vector3d(0, 0, 0), Vector3d(0.4, 0.1, 0.7), Vector3d(0.5, 0.5, 0.5)}) {
        CAPTURE(name, h, offset.transpose());
        const Vector3d cell = h * Vector3d(1.0, 1.1, 0.9);
        const BaseMesh mesh = immersed_mesh(surface, {cell, offset.cwiseProduct(cell)});
        CHECK(validate(mesh).empty());
        CHECK(validate(*mesh.body, mesh).empty());
        const double volume = material_volume(*mesh.body), left_out = left_out_volume(*mesh.body);
        CHECK(left_out < 1e-11 * volume);  // tips of the surface in cells that do not exist
        CHECK_THAT(volume + left_out, WithinRel(enclosed_volume(surface), 1e-13));
        const auto& share = mesh.body->share;
        CHECK(std::any_of(share.begin(), share.end(), [](double s) { return s < 0.5; }));
        if (h < 0.01) CHECK(std::count(share.begin(), share.end(), 1.0) > 10);
        CHECK(static_cast<double>(share.size()) * cell.prod() > 1.05 * enclosed_volume(surface));
      }
}

TEST_CASE("the share of a random box is that of brute-force clipping", "[immersed][share]") {
  std::mt19937 generator(7);
  const std::array<TriangleSurface, 4> convex = {
      icosphere(1, 0.5), closed_box({1.0, 0.7, 0.4}, {0, 0, 0}, oblique_turn(), 2),
      closed_tetrahedron({Vector3d(-0.5, -0.4, -0.3), {0.6, -0.2, 0.1}, {0.0, 0.5, -0.2}, {0.1, 0.0, 0.6}}),
      closed_box({0.9, 0.9, 0.9})};
  for (const TriangleSurface& surface : convex) {
    const auto halves = half_spaces(surface);
    int cut = 0;
    for (int sample = 0; sample < 150; ++sample) {
      const double h = 0.11 + 0.4 * std::abs(random_number(generator));
      ImmersedBody body;
      body.surface = surface;
      body.origin = Vector3d::Constant(-0.7) + 0.05 * random_vector(generator);
      body.cell_size = Vector3d(h, 0.9 * h, 1.2 * h);
      Vector3d corner;
      for (int axis = 0; axis < 3; ++axis) {
        body.lattice_cells[axis] = static_cast<int>(1.5 / body.cell_size[axis]) + 1;
        corner[axis] = std::floor((0.4 * random_number(generator) - body.origin[axis]) / body.cell_size[axis]);
      }
      index_surface(body);
      const BoundingBox box = random_box(corner, generator);
      const Vector3d low = body.origin + body.cell_size.cwiseProduct(box.lower);
      const Vector3d high = body.origin + body.cell_size.cwiseProduct(box.upper);
      auto all = halves;
      for (int axis = 0; axis < 3; ++axis) {
        all.push_back({Vector3d::Unit(axis), high[axis]});
        all.push_back({-Vector3d::Unit(axis), -low[axis]});
      }
      const double volume = (high - low).prod(), expected = convex_volume(all, 0.5 * (low + high)) / volume;
      CAPTURE(sample, h, low.transpose(), high.transpose());
      // The brute force finds corners to some 1e-13 of a unit, in boxes with edges of a hundredth and more.
      CHECK_THAT(integrated_share(body, box), WithinAbs(expected, 1e-10));
      cut += expected > 1e-6 && expected < 1.0 - 1e-6;
    }
    CHECK(cut > 30);
  }
}

TEST_CASE("volume and inertia of an immersed sphere err by the square of the cell", "[immersed][share]") {
  const double R = 0.05;
  const Vector3d centre(0.013, -0.007, 0.021);
  ErrorSeries volume{"volume", {}, {}}, inertia{"second moment", {}, {}}, mass_centre{"centre of mass", {}, {}};
  for (const int n : {4, 6, 9, 13, 20}) {  // cells along the radius; triangles shrink with the cells
    const double h = R / n;
    double volume_error = 0.0, inertia_error = 0.0, centre_error = 0.0;
    std::mt19937 generator(static_cast<unsigned>(n));
    constexpr int offsets = 6;
    for (int k = 0; k < offsets; ++k) {
      const Vector3d origin = h * random_vector(generator);
      const BaseMesh mesh = immersed_mesh(icosphere(2 * n, R, centre), {Vector3d::Constant(h), origin});
      double V = 0.0, I = 0.0;
      Vector3d moment = Vector3d::Zero();
      for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
        const Vector3d X = 0.5 * (mesh.nodes.col(mesh.cells[cell][0]) + mesh.nodes.col(mesh.cells[cell][7])) - centre;
        const double dV = mesh.body->share[cell] * h * h * h;
        V += dV;
        I += dV * X.squaredNorm();
        moment += dV * X;
      }
      volume_error += std::abs(V / (4.0 / 3.0 * pi * R * R * R) - 1.0) / offsets;
      inertia_error += (I / (4.0 / 5.0 * pi * std::pow(R, 5)) - 1.0) / offsets;
      centre_error += (moment / V).squaredNorm() / offsets;
    }
    for (ErrorSeries* series : {&volume, &inertia, &mass_centre}) series->h.push_back(h / R);
    volume.error.push_back(volume_error);
    inertia.error.push_back(inertia_error);
    mass_centre.error.push_back(std::sqrt(centre_error) / R);
  }
  INFO(convergence_table({volume, inertia, mass_centre}));
  CHECK_THAT(fitted_order(volume), WithinAbs(2.0, 0.05));  // the polyhedron's; its share is exact
  CHECK(volume.error.back() < 5e-4);
  // Material counts at its cell's centre. That takes h²/4 from each part of the volume; in cut cells the centres lie
  // outwards of the material, by h²/12 per surface and hence 2 R h²/12 of X². Per 4/5 π R⁵: (10/12 - 5/12) (h/R)². The
  // polyhedron itself lacks 5/3 of what it lacks in volume.
  CHECK_THAT(fitted_order(inertia), WithinAbs(2.0, 0.05));
  for (std::size_t k = 0; k < inertia.h.size(); ++k)
    CHECK_THAT(inertia.error[k] + 5.0 / 3.0 * volume.error[k], WithinRel(5.0 / 12.0 * std::pow(inertia.h[k], 2), 0.05));
  // Of second order per cut cell, and these errors point along the normals, whose sum over a closed surface is zero.
  CHECK(fitted_order(mass_centre) > 2.0);
  CHECK(fitted_order(mass_centre) < 5.0);
  CHECK(mass_centre.error.front() < 0.05 * mass_centre.h.front() * mass_centre.h.front());
}

TEST_CASE("cells inside are full and surfaces in lattice planes add no layer, bit for bit", "[immersed][share]") {
  // 0.1 and 0.3 are no binary fractions: the planes of surface and lattice differ by round-off.
  std::mt19937 generator(9);
  for (int sample = 0; sample < 40; ++sample)
    for (const bool given : {false, true}) {
      const Vector3d centre = 5.0 * random_vector(generator);
      const TriangleSurface box = closed_box({0.5, 0.3, 0.7}, centre, Eigen::Matrix3d::Identity(), 3);
      ImmersedMeshOptions options{Vector3d::Constant(0.1), {}};
      if (given) options.origin = centre + Vector3d(0.05, 0.25, -1.05);
      const BaseMesh mesh = immersed_mesh(box, options);
      CHECK(mesh.body->lattice_cells == std::array{5, 3, 7});
      CHECK(mesh.cells.size() == 5 * 3 * 7);
      CHECK(mesh.nodes.cols() == 6 * 4 * 8);
      // Faces miss their planes by some 1e-15 m, 1e-14 of a cell.
      CHECK(std::all_of(mesh.body->share.begin(), mesh.body->share.end(), [](double share) { return share == 1.0; }));
    }
  // A ball's inner cells: full to the bit where all corners and hence, the ball being convex, all of the cell is
  // inside.
  const BaseMesh ball = immersed_mesh(icosphere(9, 1.0, {0.1, 0.2, 0.3}), {Vector3d(0.13, 0.17, 0.11), {}});
  int inner = 0;
  for (std::size_t cell = 0; cell < ball.cells.size(); ++cell) {
    double least = 1.0;
    for (int c = 0; c < 8; ++c)
      least = std::min(least, 0.97 - (ball.nodes.col(ball.cells[cell][c]) - Vector3d(0.1, 0.2, 0.3)).norm());
    if (least <= 0.0) continue;  // the polyhedron reaches in to cos(edge / 2) at the least
    ++inner;
    CHECK(ball.body->share[cell] == 1.0);
  }
  CHECK(inner > 500);
}

TEST_CASE("a body scaled by a power of two has the same shares bit by bit", "[immersed][share]") {
  const TriangleSurface surface = bodies()[3].surface;
  const BaseMesh mesh = immersed_mesh(surface, {Vector3d(0.011, 0.013, 0.012), {}});
  for (const double scale : {std::ldexp(1.0, -20), std::ldexp(1.0, 37)}) {
    TriangleSurface scaled = surface;
    scaled.vertices *= scale;
    const BaseMesh other = immersed_mesh(scaled, {scale * Vector3d(0.011, 0.013, 0.012), {}});
    CHECK(other.body->place == mesh.body->place);
    CHECK(other.body->share == mesh.body->share);
    CHECK(same_bits(other.nodes, scale * mesh.nodes));
  }
}

TEST_CASE("a share is 0 or 1 to the bit where round-off alone is in the way", "[immersed][share]") {
  CHECK(rounded_share(0.5 * full_or_empty) == 0.0);
  CHECK(rounded_share(-0.5 * full_or_empty) == 0.0);
  CHECK(rounded_share(2.0 * full_or_empty) == 2.0 * full_or_empty);
  CHECK(rounded_share(1.0 - 0.5 * full_or_empty) == 1.0);
  CHECK(rounded_share(1.0 + 0.5 * full_or_empty) == 1.0);
  CHECK(rounded_share(1.0 - 2.0 * full_or_empty) == 1.0 - 2.0 * full_or_empty);
  // Nine plates above each other: in the gaps many layers of surface must cancel.
  TriangleSurface plates;
  for (int k = 0; k < 9; ++k) {
    const TriangleSurface plate = icosphere(7);
    const int first = static_cast<int>(plates.vertices.cols());
    plates.vertices.conservativeResize(3, first + plate.vertices.cols());
    plates.vertices.rightCols(plate.vertices.cols()) =
        (Vector3d(1.0, 0.9, 0.3).asDiagonal() * plate.vertices).colwise() + Vector3d(0.1 * k, 0.0, 1.1 * k);
    for (const auto& [a, b, c] : plate.triangles) plates.triangles.push_back({first + a, first + b, first + c});
  }
  const BaseMesh mesh = immersed_mesh(plates, {Vector3d(0.31, 0.23, 0.1), {}});
  const ImmersedBody& body = *mesh.body;
  double farthest = 0.0;
  int round = 0, exact = 0;
  for (int k = 0; k < body.lattice_cells[2]; ++k)
    for (int j = 0; j < body.lattice_cells[1]; ++j)
      for (int i = 0; i < body.lattice_cells[0]; ++i) {
        const double share = integrated_share(body, {Vector3d(i, j, k), Vector3d(i + 1, j + 1, k + 1)});
        const double off = std::min(std::abs(share), std::abs(1.0 - share));
        if (off > 1e-9) continue;
        farthest = std::max(farthest, off);
        ++(off > 0.0 ? round : exact);
        CHECK((rounded_share(share) == 0.0 || rounded_share(share) == 1.0));
      }
  CAPTURE(farthest, round, exact);
  CHECK(round > 20);        // or there was nothing to round
  CHECK(farthest < 1e-14);  // a hundredth of what rounds off
}

TEST_CASE("triangles ten thousand times the box do not blur it", "[immersed][share]") {
  // Over an edge of large triangles both must cut it at the same point: an error of 1e-15 of the edge is 1e-11 of the
  // box.
  const TriangleSurface surface = closed_box({30.0, 25.0, 20.0}, {0, 0, 0}, oblique_turn());
  const BaseMesh mesh = immersed_mesh(surface, {Vector3d(3.1, 2.9, 3.3), {}});
  const ImmersedBody& body = *mesh.body;
  std::mt19937 generator(31);
  int boxes = 0;
  double worst = 0.0;
  for (int sample = 0; sample < 400; ++sample) {
    const auto& t = surface.triangles[generator() % surface.triangles.size()];
    const int from = static_cast<int>(generator() % 3);
    const double s = 0.5 + 0.45 * random_number(generator);
    const auto& v = body.lattice_vertices;
    const Vector3d X = (1.0 - s) * v.col(t[from]) + s * v.col(t[(from + 1) % 3]);
    const Vector3d middle(X.x(), X.y(), X.z() + 2.0 * random_number(generator));
    const BoundingBox box{middle.array() - 5e-4, middle.array() + 5e-4};
    if ((box.lower.array().floor() != box.upper.array().floor()).any()) continue;  // not in one lattice cell
    const double share = integrated_share(body, box), off = std::min(std::abs(share), std::abs(1.0 - share));
    if (off > 1e-6) continue;  // cut
    ++boxes;
    worst = std::max(worst, off);
  }
  CAPTURE(worst);
  CHECK(boxes > 200);
  CHECK(worst < 1e-14);
}

TEST_CASE("children share what their parent has, whatever the templates", "[immersed][share][forest]") {
  const std::array<RefinementTemplate, 4> templates = {{{{2, 2, 2}}, {{3, 3, 3}}, {{2, 3, 3}}, {{4, 1, 3}}}};
  for (const auto& [name, surface] : bodies()) {
    CAPTURE(name);
    std::mt19937 generator(11);
    RefinementForest forest(immersed_mesh(surface, {Vector3d::Constant(0.021), {}}));
    REQUIRE(refine_randomly(forest, {templates, 200, 5, 6000}, generator) > 100);
    CHECK(validate(forest).empty());
    int cut = 0, empty = 0;
    double worst = 0.0;
    for (int handle = 0; handle < forest.handle_count(); ++handle) {
      const auto& cell = forest.cell(handle);
      if (cell.first_child < 0) continue;
      double sum = 0.0;
      for (int k = 0; k < cell.refinement.child_count(); ++k) {
        const double share = forest.cell(cell.first_child + k).share;
        sum += share / cell.refinement.child_count();
        cut += share > 0.0 && share < 1.0;
        empty += share == 0.0;
      }
      worst = std::max(worst, std::abs(sum - cell.share));
    }
    CAPTURE(worst);
    CHECK(worst < 1e-12);
    CHECK(cut > 100);
    CHECK(empty > 20);
    // A cell that no triangle reaches is all in or all out, to the bit.
    const Mesh leaves = forest.leaf_mesh();
    const ImmersedBody& body = *forest.base().body;
    int untouched = 0;
    for (int leaf = 0; leaf < leaves.cell_count(); ++leaf) {
      const BoundingBox box = lattice_box(body, leaves.frames[leaf]);
      const auto apart = [&](const BoundingBox& other) {
        return (other.lower.array() > box.upper.array()).any() || (other.upper.array() < box.lower.array()).any();
      };
      if (!std::all_of(body.triangle_boxes.begin(), body.triangle_boxes.end(), apart)) continue;
      ++untouched;
      const Vector3d middle = body.origin + 0.5 * body.cell_size.cwiseProduct(box.lower + box.upper);
      CHECK(leaves.fraction[leaf] == (contains(body, middle) ? 1.0 : 0.0));
    }
    CHECK(untouched > 20);
    // The leaves of every level of the hierarchy hold the whole body.
    for (const int height : {0, 1, 2}) {
      const Mesh mesh = forest.leaf_mesh(height);
      REQUIRE(static_cast<int>(mesh.fraction.size()) == mesh.cell_count());
      double volume = 0.0;
      for (int cell = 0; cell < mesh.cell_count(); ++cell)
        volume += mesh.fraction[cell] * share_of_base_cell(forest.cell(mesh.forest_cell[cell])) * std::pow(0.021, 3);
      CHECK_THAT(volume, WithinRel(enclosed_volume(surface), 1e-12));
    }
  }
}

TEST_CASE("a cut by a plane adds one corner at most, however coordinates are rounded", "[immersed][share]") {
  // Corners on few planes, so that edges lie in the planes that cut, or miss them by a rounding.
  std::mt19937 generator(6);
  const auto coordinate = [&] { return (static_cast<int>(generator() % 7) - 3) / (generator() % 2 == 0 ? 3.0 : 7.0); };
  int cut = 0, most = 0, beyond = 0, too_many = 0;
  for (int trial = 0; trial < 200000; ++trial) {
    ClippedPolygon polygon;
    for (int c = 0; c < 3; ++c) polygon.add({coordinate(), coordinate(), coordinate()});
    Vector3d low = polygon.corners[0], high = low;
    for (int c = 1; c < 3; ++c) {
      low = low.cwiseMin(polygon.corners[c]);
      high = high.cwiseMax(polygon.corners[c]);
    }
    for (int plane = 0; plane < 6 && polygon.count > 0; ++plane) {
      const int axis = static_cast<int>(generator() % 3);
      const ClippedPolygon part = clipped(polygon, axis, plane % 2 == 0 ? Side::above : Side::below, coordinate());
      cut += part.count > polygon.count;
      too_many += part.count > polygon.count + 1;
      most = std::max(most, part.count);
      for (int c = 0; c < part.count; ++c)
        beyond += (part.corners[c].array() < low.array()).any() || (part.corners[c].array() > high.array()).any();
      polygon = part;
    }
  }
  CHECK(cut > 10000);
  CHECK(most >= 6);
  CHECK(too_many == 0);
  CHECK(beyond == 0);
}
