#include "core/mesh/material_share.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "core/mesh/clipped_polygon.hpp"

namespace finegauge {
namespace {

/// The column starts at (0, 0), the box at z = 0.
using Polygon = ClippedPolygon;

/// ∫ n_z dA and ∫ z n_z dA.
struct Flux {
  double area = 0.0, moment = 0.0;
};
Flux upward_flux(const Polygon& polygon) {
  Flux flux;
  const Eigen::Vector3d& a = polygon.corners[0];
  for (int c = 2; c < polygon.count; ++c) {
    const Eigen::Vector3d &b = polygon.corners[c - 1], &d = polygon.corners[c];
    const double part = 0.5 * ((b.x() - a.x()) * (d.y() - a.y()) - (d.x() - a.x()) * (b.y() - a.y()));
    flux.area += part;
    flux.moment += part * (a.z() + b.z() + d.z()) / 3.0;
  }
  return flux;
}

/// The parts of a polygon in the box's column by their heights: visit(polygon, between) with `between` for what lies
/// between the box's floor and its lid; what lies above it, and a part in the plane of the lid, is not. What lies below
/// is not visited.
template <class Visit>
void visit_by_height(const Polygon& polygon, double height, const Visit& visit) {
  if (polygon.count < 3) return;
  double lowest = polygon.corners[0].z(), highest = lowest;
  for (int c = 1; c < polygon.count; ++c) {
    lowest = std::min(lowest, polygon.corners[c].z());
    highest = std::max(highest, polygon.corners[c].z());
  }
  if (highest <= 0.0) return;
  if (lowest >= height) return visit(polygon, false);
  if (lowest >= 0.0 && highest <= height) return visit(polygon, true);
  const Polygon from_floor = clipped(polygon, 2, Side::above, 0.0);
  visit(clipped(from_floor, 2, Side::below, height), true);
  visit(clipped(from_floor, 2, Side::above, height), false);
}

/// ∫ clamp(z, 0, height) n_z dA.
double clamped_flux(const Polygon& polygon, double height) {
  double sum = 0.0;
  visit_by_height(polygon, height, [&](const Polygon& part, bool between) {
    const Flux flux = upward_flux(part);
    sum += between ? flux.moment : height * flux.area;
  });
  return sum;
}

/// 1, x, y, z, yz, zx, xy: what the means are averages of.
using Monomials = Eigen::Array<double, 7, 1>;

/// ∫ m dz from 0 to z for each of them, times n_z dA / dA: over a triangle by the rule of its corners, the middles of
/// its edges and its centre, exact to degree 3 (Stroud 1971, T2: 3-7). With `height` the integrals stop there.
void add_moments(const Polygon& polygon, std::optional<double> height, Monomials& sum) {
  const auto at = [&](const Eigen::Vector3d& p) {
    const double x = p.x(), y = p.y(), z = height.value_or(p.z());
    return Monomials{{z, x * z, y * z, 0.5 * z * z, 0.5 * y * z * z, 0.5 * z * z * x, x * y * z}};
  };
  const Eigen::Vector3d& a = polygon.corners[0];
  for (int c = 2; c < polygon.count; ++c) {
    const Eigen::Vector3d &b = polygon.corners[c - 1], &d = polygon.corners[c];
    const double part = 0.5 * ((b.x() - a.x()) * (d.y() - a.y()) - (d.x() - a.x()) * (b.y() - a.y()));
    sum += part *
           (0.05 * (at(a) + at(b) + at(d)) + 2.0 / 15.0 * (at(0.5 * (a + b)) + at(0.5 * (b + d)) + at(0.5 * (d + a))) +
            0.45 * at((a + b + d) / 3.0));
  }
}

/// What a polygon in the column gives to the moments of the part of the box below it.
void add_clamped_moments(const Polygon& polygon, double height, Monomials& sum) {
  visit_by_height(polygon, height, [&](const Polygon& part, bool between) {
    add_moments(part, between ? std::nullopt : std::optional<double>(height), sum);
  });
}

/// Calls visit(polygon) for what lies of each triangle in the box's column, from the box's lower corner; upside down
/// (the file's header) from its upper one in z, and then `upside_down` is true.
template <class Visit>
bool visit_column(const ImmersedBody& body, const BoundingBox& box, const Visit& visit) {
  const Eigen::Vector3d size = box.upper - box.lower;
  assert(size.minCoeff() > 0.0);
  std::array<int, 2> place;
  for (int axis = 0; axis < 2; ++axis)
    place[axis] = std::clamp(static_cast<int>(std::floor(0.5 * (box.lower[axis] + box.upper[axis]))), 0,
                             body.lattice_cells[axis] - 1);
  const int column = place[0] + body.lattice_cells[0] * place[1];
  const bool upside_down = box.lower.z() + box.upper.z() < body.lattice_cells[2];
  for (int k = body.column_start[column]; k < body.column_start[column + 1]; ++k) {
    const int triangle = body.column_triangles[k];
    const BoundingBox& around = body.triangle_boxes[triangle];
    if (upside_down ? around.lower.z() >= box.upper.z() : around.upper.z() <= box.lower.z()) continue;
    bool misses = false;
    for (int axis = 0; axis < 2; ++axis)
      misses = misses || around.upper[axis] <= box.lower[axis] || around.lower[axis] >= box.upper[axis];
    if (misses) continue;
    Polygon polygon;
    for (const int vertex : body.surface.triangles[triangle]) {
      Eigen::Vector3d corner = body.lattice_vertices.col(vertex) - box.lower;
      if (upside_down) corner.z() = box.upper.z() - body.lattice_vertices(2, vertex);
      polygon.add(corner);
    }
    for (int axis = 0; axis < 2; ++axis) {
      if (around.lower[axis] < box.lower[axis]) polygon = clipped(polygon, axis, Side::above, 0.0);
      if (around.upper[axis] > box.upper[axis]) polygon = clipped(polygon, axis, Side::below, size[axis]);
    }
    visit(polygon);
  }
  return upside_down;
}

}  // namespace

BoundingBox lattice_box(const ImmersedBody& body, const LeafFrame& frame) {
  constexpr double unit = static_cast<double>(lattice_unit(CellShape::hexahedron));
  const auto& [lower, size, unused_a, unused_b] = frame.corners;
  BoundingBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = body.place[frame.base_cell][axis];
    box.lower[axis] = place + static_cast<double>(lower[axis]) / unit;
    box.upper[axis] = place + static_cast<double>(lower[axis] + size[axis]) / unit;
  }
  return box;
}

double integrated_share(const ImmersedBody& body, const BoundingBox& box) {
  const Eigen::Vector3d size = box.upper - box.lower;
  double sum = 0.0;
  const bool upside_down =
      visit_column(body, box, [&](const Polygon& polygon) { sum += clamped_flux(polygon, size.z()); });
  return (upside_down ? -sum : sum) / size.prod();
}

MaterialMeans integrated_means(const ImmersedBody& body, const BoundingBox& box) {
  const Eigen::Vector3d size = box.upper - box.lower;
  Monomials sum = Monomials::Zero();
  const bool upside_down =
      visit_column(body, box, [&](const Polygon& polygon) { add_clamped_moments(polygon, size.z(), sum); });
  // The sign that goes with the way of looking drops out of the averages. Round-off may leave nothing to average.
  if (sum[0] == 0.0) return means_of_full_cell;
  const double x = sum[1] / sum[0] / size.x(), y = sum[2] / sum[0] / size.y(), z = sum[3] / sum[0] / size.z();
  const double yz = sum[4] / sum[0] / (size.y() * size.z()), zx = sum[5] / sum[0] / (size.z() * size.x()),
               xy = sum[6] / sum[0] / (size.x() * size.y());
  if (!upside_down) return {x, y, z, yz, zx, xy};
  return {x, y, 1.0 - z, y - yz, x - zx, xy};
}

double rounded_share(double integrated) {
  if (!(integrated > full_or_empty)) return 0.0;
  return integrated < 1.0 - full_or_empty ? integrated : 1.0;
}

double material_share(const ImmersedBody& body, const LeafFrame& frame) {
  const BoundingBox box = lattice_box(body, frame);
  if ((box.upper - box.lower).minCoeff() > 0.0) return rounded_share(integrated_share(body, box));
  return contains(body, body.origin + body.cell_size.cwiseProduct(box.lower)) ? 1.0 : 0.0;
}

MaterialMeans material_means(const ImmersedBody& body, const LeafFrame& frame, double share) {
  if (!(0.0 < share && share < 1.0)) return means_of_full_cell;
  MaterialMeans means = integrated_means(body, lattice_box(body, frame));
  for (double& mean : means) mean = std::clamp(mean, 0.0, 1.0);
  return means;
}

}  // namespace finegauge
