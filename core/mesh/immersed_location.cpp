#include "core/mesh/immersed_location.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/mesh/immersed_body.hpp"

namespace finegauge {
namespace {

/// Share of the slack that round-off of natural coordinates may take: 1e-14 in a base cell.
constexpr double rounding = 1e-6;

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

LeafMap leaf_map(std::array<Eigen::Vector3d, 8> corners) {
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
void clip(int axis, double side, double most, Piece& piece) {
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

/// The whole triangle, cut to the leaf and `slack` around it; false where nothing is left.
bool cut_to_leaf(double slack, Piece& piece) {
  const Eigen::Vector3d b = piece.xi_0 + piece.xi_a, c = piece.xi_0 + piece.xi_b;
  if (!(piece.xi_0.cwiseMin(b).cwiseMin(c).maxCoeff() <= 1.0 + slack &&
        piece.xi_0.cwiseMax(b).cwiseMax(c).minCoeff() >= -slack))
    return false;
  piece.corners[0] = Place::Zero();
  piece.corners[1] = Place::UnitX();
  piece.corners[2] = Place::UnitY();
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
std::optional<Bounded> bound(const Piece& piece, Place& place) {
  if (!(place.minCoeff() >= -location_slack && place.sum() <= 1.0 + location_slack)) return std::nullopt;
  place = place.cwiseMax(0.0);
  place /= std::max(1.0, place.sum());
  const Eigen::Vector3d xi = piece.xi(place), inside = xi.cwiseMax(0.0).cwiseMin(1.0);
  const double moved = (xi - inside).cwiseAbs().maxCoeff();
  if (!(moved <= piece.slack)) return std::nullopt;
  return Bounded{inside, moved};
}
/// Added [m] to the distance of what was moved by more than round-off, so that the leaf in which it lies comes first.
double handicap(const Piece& piece, const Bounded& at, double leaf_size) {
  return at.moved > rounding * piece.slack ? 4.0 * piece.slack * leaf_size : 0.0;
}

/// A step of Newton's method, measured in the leaf: far outside of it there is nothing to find. Quadratic: once below
/// 1e-8, a step that is no longer shorter than half of the last is round-off.
enum class Progress { on, done, lost };
Progress progress(const Piece& piece, const Place& place, const Eigen::Vector2d& step, double& last) {
  const double length = piece.length(step);
  if (!std::isfinite(length) || !((piece.xi(place).array() - 0.5).abs().maxCoeff() < 2.5)) return Progress::lost;
  if (length < 1e-15 || (length < 1e-8 && !(length < 0.5 * last))) return Progress::done;
  last = length;
  return Progress::on;
}
constexpr int newton_steps = 25;

/// At most half the leaf at a time: where a line all but touches the piece, whole steps run away along it.
Eigen::Vector2d limited(const Piece& piece, const Eigen::Vector2d& step) {
  const double length = piece.length(step);
  return length > 0.5 ? Eigen::Vector2d(0.5 / length * step) : step;
}

/// Where the line through the origin, with e1 and e2 across it, meets the piece, from a start; false if it does not.
bool meet(const Piece& piece, const Eigen::Vector3d& e1, const Eigen::Vector3d& e2, Place& place) {
  Eigen::Matrix<double, 2, 3> across;
  across << e1.transpose(), e2.transpose();
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < newton_steps; ++k) {
    const Eigen::Matrix2d J = across * piece.tangents(place);
    const Eigen::Vector2d step = limited(piece, -(J.inverse() * (across * piece.at(place))));
    place += step;
    const Progress now = progress(piece, place, step, last);
    if (now != Progress::on) return now == Progress::done;
  }
  return false;
}

/// A place where the distance from the origin is stationary, from a start; false if there is none near.
bool find_stationary(const Piece& piece, Place& place) {
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < newton_steps; ++k) {
    const Eigen::Vector3d xi = piece.xi(place), p = piece.map.at(xi);
    const Eigen::Matrix<double, 3, 2> tangents = piece.tangents(place);
    Eigen::Matrix2d H = tangents.transpose() * tangents, bent;
    const double mixed = p.dot(piece.map.second(xi, piece.xi_a, piece.xi_b));
    bent << p.dot(piece.map.second(xi, piece.xi_a, piece.xi_a)), mixed, mixed,
        p.dot(piece.map.second(xi, piece.xi_b, piece.xi_b));
    // The Hessian, or where it is not positive definite its Gauss-Newton part.
    if (const Eigen::Matrix2d full = H + bent; full(0, 0) > 0.0 && full.determinant() > 0.0) H = full;
    const Eigen::Vector2d step = limited(piece, -(H.inverse() * (tangents.transpose() * p)));
    place += step;
    const Progress now = progress(piece, place, step, last);
    if (now != Progress::on) return now == Progress::done;
  }
  return false;
}

/// The share of the way from one place to another at which the piece is nearest to the origin: the best of five starts,
/// then Newton's method within the way.
double nearest_share(const Piece& piece, const Place& from, const Place& to) {
  const Eigen::Vector2d way = to - from;
  const Eigen::Vector3d along = way[0] * piece.xi_a + way[1] * piece.xi_b;
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  const auto consider = [&](double share) {
    const double square = piece.at(from + share * way).squaredNorm();
    if (square < least) least = square, best = share;
  };
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) consider(share);
  double share = best;
  for (int k = 0; k < newton_steps; ++k) {
    const Eigen::Vector3d xi = piece.xi(from + share * way), p = piece.map.at(xi);
    const Eigen::Vector3d tangent = piece.map.gradient(xi) * along;
    const double square = tangent.squaredNorm(), bent = square + p.dot(piece.map.second(xi, along, along));
    if (!(square > 0.0)) break;
    const double before = share;
    share = std::clamp(share - tangent.dot(p) / (bent > 0.0 ? bent : square), 0.0, 1.0);
    if (std::abs(share - before) < 1e-15) break;
  }
  consider(share);
  return best;
}

/// Unit normal into the body: triangles are counter-clockwise seen from outside, and a leaf that is not inverted keeps
/// that. Zero where the triangle has none.
Eigen::Vector3d inward_normal(const Piece& piece, const Place& place) {
  const Eigen::Matrix<double, 3, 2> tangents = piece.tangents(place);
  return tangents.col(1).cross(tangents.col(0)).stableNormalized();
}

}  // namespace

std::optional<SurfaceHit> first_immersed_entry(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                               const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d segment = to - from;
  const double square = segment.squaredNorm();
  if (!(square > 0.0)) return std::nullopt;
  const Eigen::Vector3d lower = segment.cwiseMin(0.0), upper = segment.cwiseMax(0.0);
  const Eigen::Vector3d direction = segment.stableNormalized();
  const Eigen::Vector3d e1 = direction.unitOrthogonal(), e2 = direction.cross(e1);
  const auto near = [&](const Eigen::Vector3d& least, const Eigen::Vector3d& most) {
    return (least.array() <= upper.array()).all() && (most.array() >= lower.array()).all();
  };
  const double length = std::sqrt(square);
  double least = std::numeric_limits<double>::infinity();
  std::optional<SurfaceHit> hit;
  visit_pieces(base, mesh, u, from, near, [&](const Piece& piece, int cell, double leaf_size) {
    const Place middle = piece.middle();
    const double slack = location_slack * leaf_size / length;
    for (int start = -1; start < piece.count; ++start) {
      // A line that bends through the piece meets it twice: from beyond the ends Newton's method comes to either.
      Place place = start < 0 ? middle : Place(1.1 * piece.corners[start] - 0.1 * middle);
      if (!meet(piece, e1, e2, place)) continue;
      const std::optional<Bounded> at = bound(piece, place);
      if (!at) continue;
      const Eigen::Vector3d position = piece.map.at(at->xi);
      const double fraction = position.dot(segment) / square;
      if (!(fraction >= -slack && fraction <= 1.0 + slack)) continue;
      const double rank = fraction + handicap(piece, *at, leaf_size) / length;
      if (!(rank < least)) continue;
      const Eigen::Vector3d inward = inward_normal(piece, place);
      if (!(inward.dot(segment) > 0.0)) continue;
      least = rank;
      hit = SurfaceHit{material_point(mesh, {cell, at->xi}), from + position, inward, fraction};
    }
  });
  if (hit) hit->fraction = std::clamp(hit->fraction, 0.0, 1.0);
  return hit;
}

std::optional<SurfaceHit> nearest_immersed_surface_point(const BaseMesh& base, const Mesh& mesh,
                                                         const Eigen::Matrix3Xd& u, const Eigen::Vector3d& x,
                                                         double reach) {
  assert(reach >= 0.0);
  double least = reach * reach;
  std::optional<SurfaceHit> nearest;
  const auto near = [&](const Eigen::Vector3d& lower, const Eigen::Vector3d& upper) {
    return lower.cwiseMax(-upper).cwiseMax(0.0).squaredNorm() <= least;
  };
  visit_pieces(base, mesh, u, x, near, [&](const Piece& piece, int cell, double leaf_size) {
    const auto consider = [&](Place place) {
      const std::optional<Bounded> at = bound(piece, place);
      if (!at) return;
      const Eigen::Vector3d position = piece.map.at(at->xi);
      double square = position.squaredNorm();
      if (const double added = handicap(piece, *at, leaf_size); added > 0.0) {
        const double distance = std::sqrt(square) + added;
        square = distance * distance;
      }
      if (!(nearest ? square < least : square <= least)) return;
      const Eigen::Vector3d inward = inward_normal(piece, place);
      if (!(inward.squaredNorm() > 0.0)) return;
      least = square;
      nearest = SurfaceHit{material_point(mesh, {cell, at->xi}), x + position, inward, 0.0};
    };
    const Place middle = piece.middle();
    for (int k = -1; k < piece.count; ++k) {
      Place place = k < 0 ? middle : Place(0.5 * middle + 0.5 * piece.corners[k]);
      if (find_stationary(piece, place)) consider(place);
    }
    for (int k = 0; k < piece.count; ++k) {
      const Place &from = piece.corners[k], &to = piece.corners[(k + 1) % piece.count];
      consider(from + nearest_share(piece, from, to) * (to - from));
    }
  });
  return nearest;
}

}  // namespace finegauge
