// nearest_immersed_surface_point of immersed_location.hpp.

#include "core/mesh/immersed_location.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/mesh/immersed_pieces.hpp"

namespace finegauge {
namespace {

using namespace pieces;

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

}  // namespace

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
