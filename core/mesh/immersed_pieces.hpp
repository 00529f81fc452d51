#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "core/mesh/immersed_body.hpp"
#include "core/mesh/point_location.hpp"

/// The carried surface of an immersed body as bent pieces, a triangle and a leaf each: what the searches of
/// immersed_location.hpp have in common, and nobody else includes.
namespace finegauge::pieces {

/// Share of the slack that round-off of natural coordinates may take: 1e-14 in a base cell.
inline constexpr double rounding = 1e-6;

/// A leaf's map from natural coordinates to where its points are, relative to some point near by:
/// F(ξ) = c0 + x c1 + y c2 + x y c3 + z c4 + x z c5 + y z c6 + x y z c7.
struct LeafMap {
  std::array<Eigen::Vector3d, 8> c;

  Eigen::Vector3d at(const Eigen::Vector3d& xi) const {
    const double x = xi.x(), y = xi.y(), z = xi.z();
    return c[0] + x * (c[1] + y * (c[3] + z * c[7]) + z * c[5]) + y * (c[2] + z * c[6]) + z * c[4];
  }
  Eigen::Matrix3d gradient(const Eigen::Vector3d& xi) const {
    const double x = xi.x(), y = xi.y(), z = xi.z();
    Eigen::Matrix3d F;
    F << c[1] + y * (c[3] + z * c[7]) + z * c[5], c[2] + x * (c[3] + z * c[7]) + z * c[6],
        c[4] + x * (c[5] + y * c[7]) + y * c[6];
    return F;
  }
  /// Σ_ij v_i w_j ∂²F/∂ξ_i∂ξ_j.
  Eigen::Vector3d second(const Eigen::Vector3d& xi, const Eigen::Vector3d& v, const Eigen::Vector3d& w) const {
    return (v.x() * w.y() + v.y() * w.x()) * (c[3] + xi.z() * c[7]) +
           (v.x() * w.z() + v.z() * w.x()) * (c[5] + xi.y() * c[7]) +
           (v.y() * w.z() + v.z() * w.y()) * (c[6] + xi.x() * c[7]);
  }
  /// Bound of |F(Σ λ_k ξ_k) - Σ λ_k F(ξ_k)| for ξ_k in the cell, per direction: two coordinates between 0 and 1 have a
  /// covariance of at most 1/4, three of at most 1/2 (twice that, and the middle value times it).
  Eigen::Vector3d bend() const {
    return 0.25 * (c[3].cwiseAbs() + c[5].cwiseAbs() + c[6].cwiseAbs()) + 0.5 * c[7].cwiseAbs();
  }
};

inline LeafMap leaf_map(std::array<Eigen::Vector3d, 8> corners) {
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 8; ++k)
      if ((k >> axis) & 1) corners[k] -= corners[k & ~(1 << axis)];
  return {corners};
}

/// A place on a triangle: X = A + a (B - A) + b (C - A), a, b >= 0, a + b <= 1.
using Place = Eigen::Vector2d;

/// The part of a rest triangle in one leaf: a convex polygon of places.
struct Piece {
  const LeafMap& map;
  double slack;                       ///< surface_slack of the base cell, in the leaf's natural coordinates
  Eigen::Vector3d xi_0, xi_a, xi_b;   ///< natural coordinates of the leaf: ξ = ξ_0 + a ξ_a + b ξ_b
  std::array<Place, 9> corners = {};  ///< six cuts of a triangle
  int count = 0;

  Eigen::Vector3d xi(const Place& p) const { return xi_0 + p[0] * xi_a + p[1] * xi_b; }
  Eigen::Vector3d at(const Place& p) const { return map.at(xi(p)); }
  /// ∂p/∂a, ∂p/∂b.
  Eigen::Matrix<double, 3, 2> tangents(const Place& p) const {
    const Eigen::Matrix3d F = map.gradient(xi(p));
    Eigen::Matrix<double, 3, 2> tangents;
    tangents << F * xi_a, F * xi_b;
    return tangents;
  }
  /// How far a step goes in the leaf, in natural coordinates.
  double length(const Eigen::Vector2d& step) const { return (step[0] * xi_a + step[1] * xi_b).cwiseAbs().maxCoeff(); }
  Place middle() const {
    Place sum = Place::Zero();
    for (int k = 0; k < count; ++k) sum += corners[k];
    return sum / count;
  }
};

/// Cuts the piece to side · ξ_axis <= most.
inline void clip(int axis, double side, double most, Piece& piece) {
  std::array<Place, 9> kept;
  int count = 0;
  const auto beyond = [&](const Place& p) { return side * piece.xi(p)[axis] - most; };
  for (int k = 0; k < piece.count; ++k) {
    const Place &p = piece.corners[k], &q = piece.corners[(k + 1) % piece.count];
    const double at_p = beyond(p), at_q = beyond(q);
    if (at_p <= 0.0) kept[count++] = p;
    // A convex polygon crosses a line twice; round-off in a sliver may say otherwise.
    if ((at_p <= 0.0) != (at_q <= 0.0) && count < static_cast<int>(kept.size()))
      kept[count++] = p + at_p / (at_p - at_q) * (q - p);
    if (count == static_cast<int>(kept.size())) break;
  }
  piece.corners = kept;
  piece.count = count;
}

/// The whole triangle and `beyond` it (in a and b), cut to the leaf and `slack` around it; false where nothing is left.
inline bool cut_to_leaf(double slack, Piece& piece, double beyond = 0.0) {
  const Eigen::Vector3d b = piece.xi_0 + piece.xi_a, c = piece.xi_0 + piece.xi_b;
  if (!(piece.xi_0.cwiseMin(b).cwiseMin(c).maxCoeff() <= 1.0 + slack &&
        piece.xi_0.cwiseMax(b).cwiseMax(c).minCoeff() >= -slack))
    return false;
  piece.corners[0] = Place(-beyond, -beyond);
  piece.corners[1] = Place(1.0 + 2.0 * beyond, -beyond);
  piece.corners[2] = Place(-beyond, 1.0 + 2.0 * beyond);
  piece.count = 3;
  for (int axis = 0; axis < 3 && piece.count > 0; ++axis) {
    clip(axis, -1.0, slack, piece);
    clip(axis, 1.0, 1.0 + slack, piece);
  }
  return piece.count > 0;
}

/// Calls visit(piece, cell, leaf_size [m]) for every piece of the surface that `near(lower, upper)` may want, given a
/// box around where it is relative to `origin`; in mesh order, then by triangle.
template <class Near, class Visit>
void visit_pieces(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::Vector3d& origin,
                  const Near& near, const Visit& visit) {
  assert(base.body && mesh.shape == CellShape::hexahedron);
  const ImmersedBody& body = *base.body;
  const TriangleSurface& surface = body.surface;
  const double unit = static_cast<double>(lattice_unit(CellShape::hexahedron));
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const LeafFrame& frame = mesh.frames[cell];
    const int first = body.cell_start[frame.base_cell], end = body.cell_start[frame.base_cell + 1];
    if (first == end) continue;
    std::array<Eigen::Vector3d, 8> corners;
    Eigen::Vector3d lower = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), upper = -lower;
    for (int c = 0; c < 8; ++c) {
      const int node = mesh.cells[cell][c];
      corners[c] = (mesh.nodes.col(node) + u.col(node)) - origin;
      lower = lower.cwiseMin(corners[c]);
      upper = upper.cwiseMax(corners[c]);
    }
    Eigen::Vector3d leaf_corner, size;  // in lattice coordinates of the body
    for (int axis = 0; axis < 3; ++axis) {
      leaf_corner[axis] = body.place[frame.base_cell][axis] + static_cast<double>(frame.corners[0][axis]) / unit;
      size[axis] = static_cast<double>(frame.corners[1][axis]) / unit;
    }
    const double slack = std::min(surface_slack / size.minCoeff(), 0.1), leaf_size = (upper - lower).maxCoeff();
    const double margin = 4.0 * slack * leaf_size;  // what lies past the leaf by the slack is still near
    lower.array() -= margin;
    upper.array() += margin;
    if (!near(lower, upper)) continue;

    const LeafMap map = leaf_map(corners);
    const Eigen::Vector3d bend = map.bend().array() + margin;
    for (int k = first; k < end; ++k) {
      const auto& vertices = surface.triangles[body.cell_triangles[k]];
      const Eigen::Vector3d A = body.lattice_vertices.col(vertices[0]);
      Piece piece{map, slack, (A - leaf_corner).cwiseQuotient(size), {}, {}};
      piece.xi_a = (body.lattice_vertices.col(vertices[1]) - A).cwiseQuotient(size);
      piece.xi_b = (body.lattice_vertices.col(vertices[2]) - A).cwiseQuotient(size);
      // Round-off must not lose what lies in a face of the leaf; the whole slack is for what no other leaf has.
      if (!cut_to_leaf(rounding * slack, piece) && !cut_to_leaf(0.5 * slack, piece)) continue;
      Eigen::Vector3d least = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), most = -least;
      for (int c = 0; c < piece.count; ++c) {
        const Eigen::Vector3d p = piece.at(piece.corners[c]);
        least = least.cwiseMin(p);
        most = most.cwiseMax(p);
      }
      if (near(least - bend, most + bend)) visit(piece, cell, leaf_size);
    }
  }
}

/// A place of the piece, in the leaf, and by how much it was moved to be there, in natural coordinates.
struct Bounded {
  Eigen::Vector3d xi;
  double moved;
};
/// Moves a place that is at most the slack outside of the triangle or the leaf onto them; none farther out.
inline std::optional<Bounded> bound(const Piece& piece, Place& place) {
  if (!(place.minCoeff() >= -location_slack && place.sum() <= 1.0 + location_slack)) return std::nullopt;
  place = place.cwiseMax(0.0);
  place /= std::max(1.0, place.sum());
  const Eigen::Vector3d xi = piece.xi(place), inside = xi.cwiseMax(0.0).cwiseMin(1.0);
  const double moved = (xi - inside).cwiseAbs().maxCoeff();
  if (!(moved <= piece.slack)) return std::nullopt;
  return Bounded{inside, moved};
}
/// Added [m] to the distance of what was moved by more than round-off, so that the leaf in which it lies comes first.
inline double handicap(const Piece& piece, const Bounded& at, double leaf_size) {
  return at.moved > rounding * piece.slack ? 4.0 * piece.slack * leaf_size : 0.0;
}

/// A step of Newton's method, measured in the leaf: far outside of it there is nothing to find. Quadratic: once below
/// 1e-8, a step that is no longer shorter than half of the last is round-off.
enum class Progress { on, done, lost };
inline Progress progress(const Piece& piece, const Place& place, const Eigen::Vector2d& step, double& last) {
  const double length = piece.length(step);
  if (!std::isfinite(length) || !((piece.xi(place).array() - 0.5).abs().maxCoeff() < 2.5)) return Progress::lost;
  if (length < 1e-15 || (length < 1e-8 && !(length < 0.5 * last))) return Progress::done;
  last = length;
  return Progress::on;
}
inline constexpr int newton_steps = 25;

/// At most half the leaf at a time: where a line all but touches the piece, whole steps run away along it.
inline Eigen::Vector2d limited(const Piece& piece, const Eigen::Vector2d& step) {
  const double length = piece.length(step);
  return length > 0.5 ? Eigen::Vector2d(0.5 / length * step) : step;
}

/// Unit normal into the body: triangles are counter-clockwise seen from outside, and a leaf that is not inverted keeps
/// that. Zero where the triangle has none.
inline Eigen::Vector3d inward_normal(const Piece& piece, const Place& place) {
  const Eigen::Matrix<double, 3, 2> tangents = piece.tangents(place);
  return tangents.col(1).cross(tangents.col(0)).stableNormalized();
}

}  // namespace finegauge::pieces
