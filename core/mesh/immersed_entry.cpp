// first_immersed_entry of immersed_location.hpp: every place at which a line enters a bent piece.
//
// A piece is cut in two until each part is settled. Seen along the line, g(p) has two components, and the line meets
// the piece where g = 0. A part is settled when
// - g is not zero in it: corners of the part, and bounds of the second derivatives on how far off their plane it is;
// - nothing enters in it: -det ∂g/∂p, which is > 0 at an entry, cannot be;
// - it has one place with g = 0 at most, to which Newton's method goes from its middle if there is one: with β =
//   |A⁻¹|, A = ∂g/∂p at the middle, L a bound of the second derivatives and r the part's radius, β L r <= 1/4
//   (Kantorovich 1948): the first step leaves at most r/8, and of what is left, e, each further one less than e²/(5r).
// So two places close to each other are told apart, however little there is between them. A part of radius
// smallest_part, ε, that is still not settled has -det ∂g/∂p < 5 |A| L ε in it, a sine of at most 5 ε times how much
// of its size the leaf is bent; Newton's method is tried there without a promise.

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/mesh/immersed_location.hpp"
#include "core/mesh/immersed_pieces.hpp"

namespace finegauge {
namespace {

using namespace pieces;

/// Radius of a part, in natural coordinates of the leaf, below which it is not cut any more.
constexpr double smallest_part = 0x1p-22;
/// Parts of a piece that are looked at: some ten where the line crosses it, hundreds where it grazes it. Only a piece
/// that holds a stretch of the line itself (a straight edge of a bent cell) takes thousands.
constexpr int most_parts = 1 << 16;
/// Of parts that wait: one a cut, and the longest edge of a part halves with at most three cuts.
constexpr int most_waiting = 128;

/// Where the line through the origin along the third axis meets the piece, from a start; false if it does not.
bool meet(const Piece& piece, Place& place) {
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < newton_steps; ++k) {
    const Eigen::Matrix2d J = piece.tangents(place).topRows<2>();
    const Eigen::Vector2d step = limited(piece, -(J.inverse() * piece.at(place).head<2>()));
    place += step;
    const Progress now = progress(piece, place, step, last);
    if (now != Progress::on) return now == Progress::done;
  }
  return false;
}

/// A triangle of places within a piece, in the sense of the rest triangle.
using Part = std::array<Place, 3>;

enum class Verdict { none, at_most_one, unknown };

/// Looks for entries of the line through the origin along the third axis into parts of a piece.
class PartTest {
 public:
  explicit PartTest(const Piece& piece) : piece_(piece) {
    // Orthonormal axes of the triangle in natural coordinates, so that what is said of lengths holds for slivers.
    const Eigen::Vector3d normal = piece.xi_a.cross(piece.xi_b);
    t1_ = piece.xi_a.normalized();
    t2_ = normal.cross(piece.xi_a).normalized();
    const auto& c = piece.map.c;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& coefficient : c) sum += coefficient.cwiseAbs();
    noise_ = 8.0 * std::numeric_limits<double>::epsilon() * sum.maxCoeff();
    // Of unit vectors, |Σ x_i y_j z_k| over all orders of the axes is at most 3! / 3^(3/2) (Carlen, Lieb & Loss 2006).
    third_ = 1.1548 * c[7].head<2>().norm();
  }

  /// Whether the piece is somewhere: of a place that is not a number nothing is ever settled.
  bool has_place() const { return std::isfinite(noise_); }

  /// What is known of entries in the part, between `lower` and `upper` on the line [m].
  Verdict judge(const Part& part, double lower, double upper) const {
    std::array<Eigen::Vector3d, 3> xi, g;
    for (int k = 0; k < 3; ++k) {
      xi[k] = piece_.xi(part[k]);
      g[k] = piece_.map.at(xi[k]);
    }
    if (misses(xi, g, lower, upper)) return Verdict::none;

    const Eigen::Vector3d middle = (xi[0] + xi[1] + xi[2]) / 3.0;
    const double r = radius(xi, middle);
    const Eigen::Matrix3d F = piece_.map.gradient(middle);
    Eigen::Matrix2d A;
    A << (F * t1_).head<2>(), (F * t2_).head<2>();
    const Eigen::Vector2d s11 = piece_.map.second(middle, t1_, t1_).head<2>(),
                          s12 = piece_.map.second(middle, t1_, t2_).head<2>(),
                          s22 = piece_.map.second(middle, t2_, t2_).head<2>();
    // Of the second derivatives in the ball of 1.25 r, in the Frobenius norm.
    const double L =
        std::sqrt(s11.squaredNorm() + 2.0 * s12.squaredNorm() + s22.squaredNorm()) + 2.0 * third_ * 1.25 * r;
    const double size = A.norm(), entering = -A.determinant();
    // |det(A + E) - det A| <= |A| |E| + |E|²/2.
    if (entering + (size + 0.5 * L * r) * L * r <= noise_ * size) return Verdict::none;
    if (size * L * r <= 0.25 * entering) {
      const Eigen::Vector2d g_middle = piece_.map.at(middle).head<2>();
      const double step = (A.inverse() * g_middle).norm();
      return step <= 1.13 * r + 4.0 * noise_ * size / entering ? Verdict::at_most_one : Verdict::none;
    }
    if (only_along(A, s11, s12, s22, middle, L, r)) return Verdict::none;
    return Verdict::unknown;
  }

  double radius(const Part& part) const {
    const std::array<Eigen::Vector3d, 3> xi = {piece_.xi(part[0]), piece_.xi(part[1]), piece_.xi(part[2])};
    return radius(xi, (xi[0] + xi[1] + xi[2]) / 3.0);
  }

  /// The part's two halves, across its longest edge.
  std::array<Part, 2> halves(const Part& part) const {
    int longest = 0;
    double most = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d edge = part[(k + 1) % 3] - part[k];
      const double square = (edge[0] * piece_.xi_a + edge[1] * piece_.xi_b).squaredNorm();
      if (square > most) most = square, longest = k;
    }
    const Place &a = part[longest], &b = part[(longest + 1) % 3], &c = part[(longest + 2) % 3];
    const Place half = 0.5 * (a + b);
    return {Part{a, half, c}, Part{half, b, c}};
  }

 private:
  static double radius(const std::array<Eigen::Vector3d, 3>& xi, const Eigen::Vector3d& middle) {
    return std::sqrt(
        std::max({(xi[0] - middle).squaredNorm(), (xi[1] - middle).squaredNorm(), (xi[2] - middle).squaredNorm()}));
  }

  /// Whether the part, which is off the plane of its corners by no more than its second derivatives allow, is clear of
  /// the line.
  bool misses(const std::array<Eigen::Vector3d, 3>& xi, const std::array<Eigen::Vector3d, 3>& g, double lower,
              double upper) const {
    const Eigen::Vector3d v = xi[1] - xi[0], w = xi[2] - xi[0];
    Eigen::Vector3d vv = Eigen::Vector3d::Zero(), vw = vv, ww = vv;
    for (int k = 0; k < 3; ++k) {  // linear in ξ, so most at a corner
      vv = vv.cwiseMax(piece_.map.second(xi[k], v, v).cwiseAbs());
      vw = vw.cwiseMax(piece_.map.second(xi[k], v, w).cwiseAbs());
      ww = ww.cwiseMax(piece_.map.second(xi[k], w, w).cwiseAbs());
    }
    // Two barycentric coordinates of a mean of corners have a covariance of at most 1/4.
    const Eigen::Vector3d bend = ((vv + 2.0 * vw + ww) / 8.0).array() + noise_;
    const Eigen::Vector3d least = g[0].cwiseMin(g[1]).cwiseMin(g[2]) - bend,
                          most = g[0].cwiseMax(g[1]).cwiseMax(g[2]) + bend;
    if (least.x() > 0.0 || most.x() < 0.0 || least.y() > 0.0 || most.y() < 0.0) return true;
    if (least.z() > upper || most.z() < lower) return true;
    for (int k = 0; k < 3; ++k) {  // beyond an edge
      const Eigen::Vector3d edge = g[(k + 1) % 3] - g[k];
      const Eigen::Vector2d across(-edge.y(), edge.x());
      const double here = across.dot(g[k].head<2>()), there = across.dot(g[(k + 2) % 3].head<2>());
      const double off = across.cwiseAbs().dot(bend.head<2>());
      if (std::min(here, there) > off || std::max(here, there) < -off) return true;
    }
    return false;
  }

  /// Whether the line, where it meets the part, goes along it: D = -det ∂g/∂p stays below what a smallest part can
  /// tell from zero on g = 0, where it equals D + λ · g for any λ. With the λ that takes away the slope of D across
  /// the line, that holds for a line in the surface long before D is small all over the part.
  bool only_along(const Eigen::Matrix2d& A, const Eigen::Vector2d& s11, const Eigen::Vector2d& s12,
                  const Eigen::Vector2d& s22, const Eigen::Vector3d& middle, double L, double r) const {
    const auto det = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
    const Eigen::Vector2d a1 = A.col(0), a2 = A.col(1);
    const Eigen::Vector2d slope(-det(s11, a2) - det(a1, s12), -det(s12, a2) - det(a1, s22));
    const double square = A.squaredNorm(), size = std::sqrt(square);
    if (!(square > 0.0)) return false;
    const Eigen::Vector2d lambda = -(A * slope) / square;
    const double value = -A.determinant() + lambda.dot(piece_.map.at(middle).head<2>());
    const double curvature = std::numbers::sqrt2 * third_ * (size + L * r) + L * L + lambda.norm() * L;
    return value + (slope + A.transpose() * lambda).norm() * r + 0.5 * curvature * r * r <= smallest_part * size * L;
  }

  const Piece& piece_;
  Eigen::Vector3d t1_, t2_;  ///< natural coordinates
  double noise_;             ///< round-off of a place of the piece [m]
  double third_;             ///< most that third derivatives of g along unit vectors can be [m]
};

/// Calls visit(place) for places where the line through the origin along the third axis enters the piece, between
/// lower and upper() [m]; near to each other or to the piece's border, perhaps twice or for one a little outside.
template <class Upper, class Visit>
void visit_entries(const Piece& piece, double lower, const Upper& upper, const Visit& visit) {
  const PartTest test(piece);
  if (!test.has_place()) return;
  std::array<Part, most_waiting> waiting;
  int looked_at = 0;
  for (int k = 1; k + 1 < piece.count; ++k) {
    int count = 0;
    waiting[count++] = {piece.corners[0], piece.corners[k], piece.corners[k + 1]};
    while (count > 0) {
      const Part part = waiting[--count];
      Verdict verdict = test.judge(part, lower, upper());
      if (verdict == Verdict::none) continue;
      if (verdict == Verdict::unknown &&
          (count + 2 > most_waiting || ++looked_at > most_parts || test.radius(part) < smallest_part))
        verdict = Verdict::at_most_one;
      if (verdict == Verdict::at_most_one) {
        Place place = (part[0] + part[1] + part[2]) / 3.0;
        if (meet(piece, place)) visit(place);
        continue;
      }
      for (const Part& half : test.halves(part)) waiting[count++] = half;
    }
  }
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
  Eigen::Matrix3d frame;  // right-handed, the segment along its third axis
  frame << e1.transpose(), e2.transpose(), direction.transpose();
  const auto near = [&](const Eigen::Vector3d& least, const Eigen::Vector3d& most) {
    return (least.array() <= upper.array()).all() && (most.array() >= lower.array()).all();
  };
  const double length = std::sqrt(square);
  double least = std::numeric_limits<double>::infinity();
  std::optional<SurfaceHit> hit;
  visit_pieces(base, mesh, u, from, near, [&](const Piece& piece, int cell, double leaf_size) {
    LeafMap map;
    for (int k = 0; k < 8; ++k) map.c[k] = frame * piece.map.c[k];
    Piece turned{map, piece.slack, piece.xi_0, piece.xi_a, piece.xi_b};
    if (!cut_to_leaf(piece.slack, turned, location_slack)) return;  // all that `bound` takes
    const double slack = location_slack * leaf_size / length, margin = 4.0 * piece.slack * leaf_size;
    const auto farthest = [&] { return std::min(length, least * length) + margin; };
    visit_entries(turned, -margin, farthest, [&](Place place) {
      const std::optional<Bounded> at = bound(piece, place);
      if (!at) return;
      const Eigen::Vector3d position = piece.map.at(at->xi);
      const double fraction = position.dot(segment) / square;
      if (!(fraction >= -slack && fraction <= 1.0 + slack)) return;
      const double rank = fraction + handicap(piece, *at, leaf_size) / length;
      if (!(rank < least)) return;
      const Eigen::Vector3d inward = inward_normal(piece, place);
      if (!(inward.dot(segment) > 0.0)) return;
      least = rank;
      hit = SurfaceHit{material_point(mesh, {cell, at->xi}), from + position, inward, fraction};
    });
  });
  if (hit) hit->fraction = std::clamp(hit->fraction, 0.0, 1.0);
  return hit;
}

}  // namespace finegauge
