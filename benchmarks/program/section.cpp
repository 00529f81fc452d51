#include "benchmarks/program/section.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace finegauge {
namespace {

/// Signed distances of points from the plane that is cut; never zero in effect: zero counts as beyond.
Eigen::VectorXd distances(const Eigen::Matrix3Xd& points, const SectionPlane& plane) {
  const double diagonal = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
  const double level = plane.normal.dot(plane.point) + section_offset * diagonal;
  return (plane.normal.transpose() * points).transpose() - Eigen::VectorXd::Constant(points.cols(), level);
}

bool beyond(double distance) { return distance >= 0.0; }

/// Where the plane crosses the edge between two points on either side of it.
Eigen::Vector2d crossing(const Eigen::Matrix3Xd& points, const Eigen::VectorXd& distance, int a, int b,
                         const SectionPlane& plane) {
  if (b < a) std::swap(a, b);  // an edge's crossing has the same bits in all cells around it
  const double share = distance[a] / (distance[a] - distance[b]);
  return plane((1.0 - share) * points.col(a) + share * points.col(b));
}

/// Edges as pairs of points, the smaller first.
using Edge = std::pair<int, int>;
Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

/// Closed chains of segments between edges; each edge in at most two segments.
std::vector<std::vector<Edge>> closed_chains(const std::vector<std::pair<Edge, Edge>>& segments) {
  std::map<Edge, std::array<int, 2>> at;  // the segments that end on an edge, -1: none
  for (int k = 0; k < static_cast<int>(segments.size()); ++k)
    for (const Edge& edge : {segments[k].first, segments[k].second}) {
      auto& ends = at.try_emplace(edge, std::array{-1, -1}).first->second;
      ends[ends[0] < 0 ? 0 : 1] = k;
    }
  std::vector<std::vector<Edge>> chains;
  std::vector<bool> used(segments.size(), false);
  for (int first = 0; first < static_cast<int>(segments.size()); ++first) {
    if (used[first]) continue;
    std::vector<Edge> chain = {segments[first].first};
    Edge end = segments[first].second;
    used[first] = true;
    while (end != chain.front()) {
      chain.push_back(end);
      const auto& ends = at.at(end);
      const int next = ends[0] >= 0 && !used[ends[0]] ? ends[0] : ends[1] >= 0 && !used[ends[1]] ? ends[1] : -1;
      if (next < 0) break;
      used[next] = true;
      end = segments[next].first == end ? segments[next].second : segments[next].first;
    }
    if (end == chain.front()) chains.push_back(std::move(chain));
  }
  return chains;
}

/// What the plane cuts of a face, `corners` around it: no segment, one, or two where the corners are to either side in
/// turns. Of the two ways to join those the one that keeps the face's middle with the side it is on: it depends on the
/// face alone.
void add_segments(std::span<const int> corners, const Eigen::VectorXd& distance,
                  std::vector<std::pair<Edge, Edge>>& segments) {
  std::array<Edge, 4> crossed;
  int count = 0, first = 0;
  double middle = 0.0;
  const int n = static_cast<int>(corners.size());
  for (int k = 0; k < n; ++k) {
    const int a = corners[k], b = corners[(k + 1) % n];
    middle += distance[a];
    if (beyond(distance[a]) == beyond(distance[b])) continue;
    if (count == 0) first = k;
    crossed[count++] = edge_of(a, b);
  }
  if (count == 2) segments.emplace_back(crossed[0], crossed[1]);
  if (count < 4) return;
  // Corner first + 1 lies between the first two crossings.
  const bool same_side = beyond(distance[corners[(first + 1) % n]]) == beyond(middle);
  segments.emplace_back(crossed[0], crossed[same_side ? 3 : 1]);
  segments.emplace_back(crossed[2], crossed[same_side ? 1 : 3]);
}

/// The point of the base cells nearest to X, of cells that are boxes; none when it is farther than a cell is long.
std::optional<MaterialPoint> nearest_point(const BaseMesh& base, const Eigen::Vector3d& X) {
  int nearest = -1;
  double least = 0.0;
  Eigen::Vector3d at = X;
  for (int cell = 0; cell < static_cast<int>(base.cells.size()); ++cell) {
    Eigen::Vector3d low = base.nodes.col(base.cells[cell][0]), high = low;
    for (int c = 1; c < corner_count(base.shape); ++c) {
      low = low.cwiseMin(base.nodes.col(base.cells[cell][c]));
      high = high.cwiseMax(base.nodes.col(base.cells[cell][c]));
    }
    const Eigen::Vector3d inside = X.cwiseMax(low).cwiseMin(high);
    const double distance = (inside - X).squaredNorm();
    if (distance > (high - low).squaredNorm() || (nearest >= 0 && distance >= least)) continue;
    nearest = cell;
    least = distance;
    at = inside;
  }
  if (nearest < 0) return std::nullopt;
  return locate_at_rest(base, at, nearest);
}

}  // namespace

Eigen::Vector2d SectionPlane::operator()(const Eigen::Vector3d& x) const {
  return {up.cross(normal).dot(x - point), up.dot(x - point)};
}

SectionPlane plane_along(const Eigen::Vector3d& point, const Eigen::Vector3d& direction, const Eigen::Vector3d& up) {
  const Eigen::Vector3d along = direction.normalized();
  Eigen::Vector3d upwards = up - along.dot(up) * along;
  if (upwards.squaredNorm() < 1e-6 * up.squaredNorm()) upwards = along.unitOrthogonal();
  upwards.normalize();
  return {point, along.cross(upwards), upwards};
}

std::vector<CellSection> section_of_cells(const Mesh& mesh, const Eigen::Matrix3Xd& positions,
                                          const SectionPlane& plane) {
  const Eigen::VectorXd distance = distances(positions, plane);
  const int face_size = face_corner_count(mesh.shape);
  std::vector<CellSection> sections;
  std::vector<std::pair<Edge, Edge>> segments;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    segments.clear();
    for (int face = 0; face < face_count(mesh.shape); ++face) {
      const auto& local = face_corners(mesh.shape, face);
      // Around the face: a hexahedron's corners are listed row by row.
      std::array<int, 4> corners{};
      for (int k = 0; k < face_size; ++k) corners[k] = mesh.cells[cell][local[face_size == 4 && k > 1 ? 5 - k : k]];
      add_segments(std::span(corners).first(static_cast<std::size_t>(face_size)), distance, segments);
    }
    for (const std::vector<Edge>& chain : closed_chains(segments)) {
      CellSection section{cell, {}};
      for (const auto& [a, b] : chain) section.polygon.push_back(crossing(positions, distance, a, b, plane));
      sections.push_back(std::move(section));
    }
  }
  return sections;
}

std::vector<std::vector<Eigen::Vector2d>> section_of_surface(const TriangleSurface& surface,
                                                             const SectionPlane& plane) {
  const Eigen::VectorXd distance = distances(surface.vertices, plane);
  std::vector<std::pair<Edge, Edge>> segments;
  for (const std::array<int, 3>& triangle : surface.triangles) add_segments(triangle, distance, segments);
  std::vector<std::vector<Eigen::Vector2d>> polygons;
  for (const std::vector<Edge>& chain : closed_chains(segments)) {
    std::vector<Eigen::Vector2d> polygon;
    for (const auto& [a, b] : chain) polygon.push_back(crossing(surface.vertices, distance, a, b, plane));
    polygons.push_back(std::move(polygon));
  }
  return polygons;
}

double signed_double_area(const std::vector<Eigen::Vector2d>& polygon) {
  double area = 0.0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d a = polygon[k] - polygon[0], b = polygon[(k + 1) % polygon.size()] - polygon[0];
    area += a.x() * b.y() - a.y() * b.x();
  }
  return area;
}

std::vector<MaterialPoint> points_of_surface(const BaseMesh& base, const TriangleSurface& surface) {
  std::vector<MaterialPoint> points;
  int hint = -1;
  for (Eigen::Index vertex = 0; vertex < surface.vertices.cols(); ++vertex) {
    const Eigen::Vector3d X = surface.vertices.col(vertex);
    auto point = locate_at_rest(base, X, hint);
    if (!point) point = nearest_point(base, X);
    if (!point)
      throw std::invalid_argument("vertex " + std::to_string(vertex) + " of the surface is far from all base cells");
    points.push_back(*point);
    hint = point->base_cell;
  }
  return points;
}

TriangleSurface carried_surface(const TriangleSurface& surface, const std::vector<MaterialPoint>& points,
                                const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& u) {
  TriangleSurface carried = surface;
  for (std::size_t vertex = 0; vertex < points.size(); ++vertex)
    carried.vertices.col(static_cast<Eigen::Index>(vertex)) +=
        interpolate(mesh, u, find_leaf(forest, mesh, points[vertex]));
  return carried;
}

}  // namespace finegauge
