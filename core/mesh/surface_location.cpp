// first_entry and nearest_surface_point of point_location.hpp: the deformed surface as bilinear patches and triangles.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/mesh/point_location.hpp"

namespace finegauge {
namespace {

using Corner = Eigen::Vector3d;

/// A boundary face where it is now: p(s, t) = a + s b + t c + s t d, s and t from 0 to 1 (a triangle: d = 0, s + t ≤
/// 1). In coordinates relative to some point near by.
struct Patch {
  Eigen::Vector3d a, b, c, d;
  bool triangle;

  Eigen::Vector3d at(double s, double t) const { return a + s * b + t * (c + s * d); }
  Eigen::Vector3d along_s(double t) const { return b + t * d; }
  Eigen::Vector3d along_t(double s) const { return c + s * d; }
};

/// The face's corners relative to `origin`.
std::array<Corner, 4> face_positions(const Mesh& mesh, const Eigen::Matrix3Xd& u, const BoundaryFace& face,
                                     const Eigen::Vector3d& origin) {
  std::array<Corner, 4> positions;
  const auto& corners = face_corners(mesh.shape, face.face);
  for (int c = 0; c < face_corner_count(mesh.shape); ++c) {
    const int node = mesh.cells[face.cell][corners[c]];
    positions[c] = (mesh.nodes.col(node) + u.col(node)) - origin;
  }
  if (mesh.shape == CellShape::tetrahedron) positions[3] = positions[2];
  return positions;
}

Patch patch_of(CellShape shape, const std::array<Corner, 4>& p) {
  if (shape == CellShape::tetrahedron) return {p[0], p[1] - p[0], p[2] - p[0], Eigen::Vector3d::Zero(), true};
  return {p[0], p[1] - p[0], p[2] - p[0], (p[3] - p[2]) - (p[1] - p[0]), false};
}

/// Unit normal into the body; zero where the patch has none. A hexahedron's faces list their axes cyclically, so that
/// ∂p/∂s × ∂p/∂t points along the cell's third axis; a tetrahedron may be mirrored, its opposite corner tells.
Eigen::Vector3d inward_normal(const Mesh& mesh, const Eigen::Matrix3Xd& u, const BoundaryFace& face, const Patch& patch,
                              double s, double t, const Eigen::Vector3d& origin) {
  const Eigen::Vector3d normal = patch.along_s(t).cross(patch.along_t(s)).stableNormalized();
  bool turn = face.face % 2 == 1;
  if (patch.triangle) {
    const int opposite = mesh.cells[face.cell][face.face];
    turn = normal.dot((mesh.nodes.col(opposite) + u.col(opposite)) - origin - patch.a) < 0.0;
  }
  return turn ? Eigen::Vector3d(-normal) : normal;
}

MaterialPoint point_on_face(const Mesh& mesh, const BoundaryFace& face, double s, double t) {
  LeafPoint leaf{face.cell, Eigen::Vector3d::Zero()};
  if (mesh.shape == CellShape::hexahedron) {
    const int axis = face.face / 2;
    leaf.xi[axis] = face.face % 2;
    leaf.xi[(axis + 1) % 3] = s;
    leaf.xi[(axis + 2) % 3] = t;
  } else {
    const auto& corners = tetrahedron_faces[face.face];
    const std::array<double, 3> weights = {1.0 - s - t, s, t};
    for (int c = 0; c < 3; ++c)
      if (corners[c] > 0) leaf.xi[corners[c] - 1] = weights[c];
  }
  return material_point(mesh, leaf);
}

struct PatchCoordinates {
  double s, t;
};
double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Where the line through the origin along `direction` meets the patch (Ramsey, Potter & Hansen 2004): across the line
/// two bilinear equations remain, t is eliminated. Up to two places, patch not bounded. None where it is edge-on.
int meet(const Patch& patch, const Eigen::Vector3d& direction, std::array<PatchCoordinates, 2>& places) {
  const Eigen::Vector3d e1 = direction.unitOrthogonal(), e2 = direction.normalized().cross(e1);
  const auto across = [&](const Eigen::Vector3d& v) { return Eigen::Vector2d(e1.dot(v), e2.dot(v)); };
  const Eigen::Vector2d a = across(patch.a), b = across(patch.b), c = across(patch.c), d = across(patch.d);
  // (a + s b) × (c + s d) = 0.
  const double A = cross(b, d), B = cross(a, d) + cross(b, c), C = cross(a, c);
  double discriminant = B * B - 4.0 * A * C;
  if (discriminant < 0.0) {
    // Tangent but for round-off, or no meeting.
    if (discriminant < -1e-12 * B * B) return 0;
    discriminant = 0.0;
  }
  const double q = -0.5 * (B + std::copysign(std::sqrt(discriminant), B));
  std::array<double, 2> roots = {C / q, q / A};
  int count = 0;
  for (double s : roots) {
    if (!(std::abs(s) <= 2.0)) continue;  // infinite or NaN: the patch has no such root
    const Eigen::Vector2d slope = c + s * d, place = a + s * b;
    double t = -slope.dot(place) / slope.squaredNorm();
    if (!(std::abs(t) <= 2.0)) continue;
    // One step of Newton's method takes the elimination's round-off away.
    Eigen::Matrix2d J;
    J << b + t * d, c + s * d;
    const Eigen::Vector2d step = J.inverse() * (a + s * b + t * (c + s * d));
    if (step.allFinite() && step.cwiseAbs().maxCoeff() < 1e-3) s -= step[0], t -= step[1];
    places[count++] = {s, t};
  }
  return count;
}

/// Moves a place that is at most the slack outside onto the patch; false farther out.
bool bound(bool triangle, PatchCoordinates& place) {
  const double most = triangle ? place.s + place.t : std::max(place.s, place.t);
  if (!(std::min(place.s, place.t) >= -location_slack && most <= 1.0 + location_slack)) return false;
  place = {std::max(place.s, 0.0), std::max(place.t, 0.0)};
  if (triangle) {
    const double sum = std::max(1.0, place.s + place.t);
    place = {place.s / sum, place.t / sum};
  } else {
    place = {std::min(place.s, 1.0), std::min(place.t, 1.0)};
  }
  return true;
}

/// Nearest to the origin on the segment a to a + v: its share.
double nearest_share(const Eigen::Vector3d& a, const Eigen::Vector3d& v) {
  const double square = v.squaredNorm();
  return square > 0.0 ? std::clamp(-a.dot(v) / square, 0.0, 1.0) : 0.0;
}

/// The place of the patch nearest to the origin: the nearest of its edges' and of the stationary places inside, found
/// by Newton's method from the nearest places of a lattice of starts.
PatchCoordinates nearest_place(const Patch& patch) {
  PatchCoordinates best{0.0, 0.0};
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](double s, double t) {
    const double square = patch.at(s, t).squaredNorm();
    if (square < least) least = square, best = {s, t};
  };
  const double s0 = nearest_share(patch.a, patch.b), t0 = nearest_share(patch.a, patch.c);
  consider(s0, 0.0);
  consider(0.0, t0);
  if (patch.triangle) {
    const double along = nearest_share(patch.a + patch.b, patch.c - patch.b);
    consider(1.0 - along, along);
  } else {
    consider(nearest_share(patch.a + patch.c, patch.along_s(1.0)), 1.0);
    consider(1.0, nearest_share(patch.a + patch.b, patch.along_t(1.0)));
  }
  constexpr int starts = 3;  // per axis
  const int tries = patch.triangle ? 1 : starts * starts;
  for (int k = 0; k < tries; ++k) {
    const int row = k / starts, column = k % starts;
    double s = patch.triangle ? 1.0 / 3.0 : (column + 0.5) / starts;
    double t = patch.triangle ? 1.0 / 3.0 : (row + 0.5) / starts;
    for (int iteration = 0; iteration < 20; ++iteration) {
      const Eigen::Vector3d p = patch.at(s, t), ps = patch.along_s(t), pt = patch.along_t(s);
      const double h = ps.dot(pt), bend = p.dot(patch.d), ss = ps.squaredNorm(), tt = pt.squaredNorm();
      // The Hessian, or where it is not positive definite its Gauss-Newton part.
      const double mixed = ss * tt - (h + bend) * (h + bend) > 0.0 ? h + bend : h;
      const double det = ss * tt - mixed * mixed, gs = p.dot(ps), gt = p.dot(pt);
      if (!(det > 0.0)) break;
      const double ds = (mixed * gt - tt * gs) / det, dt = (mixed * gs - ss * gt) / det;
      const double s_before = s, t_before = t;
      s = std::clamp(s + ds, 0.0, 1.0), t = std::clamp(t + dt, 0.0, 1.0);
      if (std::max(std::abs(s - s_before), std::abs(t - t_before)) < 1e-15) break;
    }
    if (!patch.triangle || s + t <= 1.0) consider(s, t);
  }
  return best;
}

}  // namespace

std::optional<SurfaceHit> first_entry(const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::Vector3d& from,
                                      const Eigen::Vector3d& to) {
  const Eigen::Vector3d segment = to - from;
  const double square = segment.squaredNorm();
  if (!(square > 0.0) || !std::isfinite(square)) return std::nullopt;
  const Eigen::Vector3d lower = segment.cwiseMin(0.0), upper = segment.cwiseMax(0.0);
  std::optional<SurfaceHit> hit;
  for (const BoundaryFace& face : mesh.boundary) {
    const std::array<Corner, 4> corners = face_positions(mesh, u, face, from);
    const Eigen::Vector3d least = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2].cwiseMin(corners[3]));
    const Eigen::Vector3d most = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2].cwiseMax(corners[3]));
    const double margin = location_slack * (most - least).maxCoeff();
    if ((least.array() > upper.array() + margin).any() || (most.array() < lower.array() - margin).any()) continue;
    const Patch patch = patch_of(mesh.shape, corners);
    std::array<PatchCoordinates, 2> places;
    const int count = meet(patch, segment, places);
    for (int k = 0; k < count; ++k) {
      auto [s, t] = places[k];
      if (PatchCoordinates place{s, t}; bound(patch.triangle, place))
        s = place.s, t = place.t;
      else
        continue;
      const double fraction = patch.at(s, t).dot(segment) / square;
      const double slack = margin / std::sqrt(square);
      if (!(fraction >= -slack && fraction <= 1.0 + slack)) continue;
      if (hit && !(fraction < hit->fraction)) continue;
      const Eigen::Vector3d inward = inward_normal(mesh, u, face, patch, s, t, from);
      if (!(inward.dot(segment) > 0.0)) continue;
      hit = SurfaceHit{point_on_face(mesh, face, s, t), from + patch.at(s, t), inward, fraction};
    }
  }
  if (hit) hit->fraction = std::clamp(hit->fraction, 0.0, 1.0);
  return hit;
}

std::optional<SurfaceHit> nearest_surface_point(const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::Vector3d& x,
                                                double reach) {
  assert(reach >= 0.0);
  double least = reach * reach;
  std::optional<SurfaceHit> nearest;
  for (const BoundaryFace& face : mesh.boundary) {
    const std::array<Corner, 4> corners = face_positions(mesh, u, face, x);
    const Eigen::Vector3d lower = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2].cwiseMin(corners[3]));
    const Eigen::Vector3d upper = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2].cwiseMax(corners[3]));
    if (!(lower.cwiseMax(-upper).cwiseMax(0.0).squaredNorm() <= least)) continue;
    const Patch patch = patch_of(mesh.shape, corners);
    const auto [s, t] = nearest_place(patch);
    const double square = patch.at(s, t).squaredNorm();
    if (!(nearest ? square < least : square <= least)) continue;
    least = square;
    nearest = SurfaceHit{point_on_face(mesh, face, s, t), x + patch.at(s, t),
                         inward_normal(mesh, u, face, patch, s, t, x), 0.0};
  }
  return nearest;
}

}  // namespace finegauge
