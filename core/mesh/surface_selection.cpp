#include "core/mesh/surface_selection.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/mesh/immersed_body.hpp"
#include "core/mesh/selection_distance.hpp"

namespace finegauge {
namespace {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// The point of a triangle nearest to p, by the region of the plane that p lies over (Ericson 2005, section 5.1.5).
Eigen::Vector3d nearest_point(const Triangle& t, const Eigen::Vector3d& p) {
  const auto& [a, b, c] = t;
  const Eigen::Vector3d ab = b - a, ac = c - a;
  const double d1 = ab.dot(p - a), d2 = ac.dot(p - a);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const double d3 = ab.dot(p - b), d4 = ac.dot(p - b);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(p - c), d6 = ac.dot(p - c);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

Eigen::Vector3d nearest_point(const std::vector<SurfaceFacet>& facets, const Eigen::Vector3d& p) {
  Eigen::Vector3d nearest = p;
  double least = std::numeric_limits<double>::infinity();
  const auto try_triangle = [&](const Triangle& triangle) {
    const Eigen::Vector3d x = nearest_point(triangle, p);
    const double squared = (x - p).squaredNorm();
    if (!(squared < least)) return;
    least = squared;
    nearest = x;
  };
  for (const SurfaceFacet& facet : facets) {
    const auto& X = facet.corners;
    try_triangle({X[0], X[1], X[2]});
    if (facet.corner_count == 4) try_triangle({X[1], X[2], X[3]});
  }
  return nearest;
}

Eigen::Matrix3Xd centres_of(const std::vector<SurfaceFacet>& facets) {
  Eigen::Matrix3Xd centres = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(facets.size()));
  for (std::size_t i = 0; i < facets.size(); ++i)
    for (int c = 0; c < facets[i].corner_count; ++c)
      centres.col(static_cast<Eigen::Index>(i)) += facets[i].corners[c] / facets[i].corner_count;
  return centres;
}

double triangle_area(const Triangle& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm(); }

/// Base cells by their place in the lattice.
class LatticeCells {
 public:
  explicit LatticeCells(const ImmersedBody& body) : body_(body) {
    const auto& n = body.lattice_cells;
    cell_at_.assign(static_cast<std::size_t>(n[0]) * n[1] * n[2], -1);
    for (std::size_t cell = 0; cell < body.place.size(); ++cell)
      cell_at_[index(body.place[cell])] = static_cast<int>(cell);
  }
  /// -1 where there is none.
  int at(const std::array<int, 3>& place) const {
    for (int axis = 0; axis < 3; ++axis)
      if (place[axis] < 0 || place[axis] >= body_.lattice_cells[axis]) return -1;
    return cell_at_[index(place)];
  }
  /// In units of cells from the lattice's corner.
  Eigen::Vector3d lattice_coordinates(const Eigen::Vector3d& x) const {
    return (x - body_.origin).cwiseQuotient(body_.cell_size);
  }
  MaterialPoint locate(const Eigen::Vector3d& X) const {
    const Eigen::Vector3d s = lattice_coordinates(X);
    std::array<int, 3> middle;
    for (int axis = 0; axis < 3; ++axis)
      middle[axis] = std::clamp(static_cast<int>(std::floor(s[axis])), 0, body_.lattice_cells[axis] - 1);
    MaterialPoint nearest;
    double least = std::numeric_limits<double>::infinity();
    // Rings of lattice cells around the point's own, until none further out can be nearer: a cell of ring r is at least
    // r - 1 cells away.
    const int last_ring = *std::max_element(body_.lattice_cells.begin(), body_.lattice_cells.end());
    const double shortest = body_.cell_size.minCoeff();
    for (int ring = 0; ring <= last_ring; ++ring) {
      const double reach = ring > 1 ? (ring - 1) * shortest : 0.0;
      if (reach * reach >= least) break;
      visit_ring(middle, ring, [&](const std::array<int, 3>& place) {
        const int cell = at(place);
        if (cell < 0) return;
        const Eigen::Vector3d lower(place[0], place[1], place[2]);
        const Eigen::Vector3d xi = (s - lower).cwiseMax(0.0).cwiseMin(1.0);
        const double squared = (lower + xi - s).cwiseProduct(body_.cell_size).squaredNorm();
        if (!(squared < least)) return;
        least = squared;
        nearest = {cell, xi};
      });
    }
    return nearest;
  }

 private:
  std::size_t index(const std::array<int, 3>& place) const {
    const auto& n = body_.lattice_cells;
    return static_cast<std::size_t>(place[0]) +
           static_cast<std::size_t>(n[0]) * (place[1] + static_cast<std::size_t>(n[1]) * place[2]);
  }
  template <class Visit>
  static void visit_ring(const std::array<int, 3>& middle, int ring, const Visit& visit) {
    for (int k = -ring; k <= ring; ++k)
      for (int j = -ring; j <= ring; ++j)
        for (int i = -ring; i <= ring; ++i)
          if (std::max({std::abs(i), std::abs(j), std::abs(k)}) == ring)
            visit({middle[0] + i, middle[1] + j, middle[2] + k});
  }

  const ImmersedBody& body_;
  std::vector<int> cell_at_;
};

void add_part(const LatticeCells& cells, const Triangle& t, std::vector<SurfacePoint>& points) {
  const double area = triangle_area(t);
  if (!(area > 0.0)) return;
  for (int q = 0; q < 3; ++q) {
    const Eigen::Vector3d X = (4.0 * t[q] + t[(q + 1) % 3] + t[(q + 2) % 3]) / 6.0;
    points.push_back({cells.locate(X), area / 3.0});
  }
}

/// Strips parallel to the shortest edge, each cut into columns: a sliver has as many parts as its length asks for, and
/// an equilateral triangle the square of that.
void add_immersed_triangle(const LatticeCells& cells, const Triangle& t, double half_cell,
                           std::vector<SurfacePoint>& points) {
  std::array<double, 3> squared;  // of the edge opposite to each corner
  for (int c = 0; c < 3; ++c) squared[c] = (t[(c + 2) % 3] - t[(c + 1) % 3]).squaredNorm();
  const int apex = static_cast<int>(std::min_element(squared.begin(), squared.end()) - squared.begin());
  const Eigen::Vector3d &A = t[apex], &B = t[(apex + 1) % 3], &C = t[(apex + 2) % 3];
  const double longest = std::sqrt(*std::max_element(squared.begin(), squared.end()));
  const int strips = std::max(1, static_cast<int>(std::ceil(longest / half_cell)));
  for (int k = 0; k < strips; ++k) {
    const double inner = static_cast<double>(k) / strips, outer = static_cast<double>(k + 1) / strips;
    const int columns = std::max(1, static_cast<int>(std::ceil(outer * std::sqrt(squared[apex]) / half_cell)));
    const auto at = [&](double share, int column) -> Eigen::Vector3d {
      const double s = static_cast<double>(column) / columns;
      return A + share * ((1.0 - s) * (B - A) + s * (C - A));
    };
    for (int column = 0; column < columns; ++column) {
      add_part(cells, {at(inner, column), at(outer, column), at(outer, column + 1)}, points);
      if (k > 0) add_part(cells, {at(inner, column), at(outer, column + 1), at(inner, column + 1)}, points);
    }
  }
}

/// Natural coordinates in the cell of a point (s, t) of its face.
Eigen::Vector3d on_face(CellShape shape, int face, double s, double t) {
  Eigen::Vector3d xi = Eigen::Vector3d::Zero();
  if (shape == CellShape::hexahedron) {
    const int axis = face / 2;
    xi[axis] = face % 2;
    xi[(axis + 1) % 3] = s;
    xi[(axis + 2) % 3] = t;
    return xi;
  }
  const std::array<double, 3> N = {1.0 - s - t, s, t};
  for (int c = 0; c < 3; ++c)
    if (const int corner = tetrahedron_faces[face][c]; corner > 0) xi[corner - 1] = N[c];
  return xi;
}

void add_face(CellShape shape, const SurfaceFacet& facet, std::vector<SurfacePoint>& points) {
  const auto& X = facet.corners;
  const auto add = [&](double s, double t, double area) {
    if (area > 0.0) points.push_back({{facet.face.cell, on_face(shape, facet.face.face, s, t)}, area});
  };
  if (facet.corner_count == 3) {
    const double area = triangle_area({X[0], X[1], X[2]});
    for (int q = 0; q < 3; ++q) add(q == 1 ? 2.0 / 3.0 : 1.0 / 6.0, q == 2 ? 2.0 / 3.0 : 1.0 / 6.0, area / 3.0);
    return;
  }
  const double offset = 0.5 / std::sqrt(3.0);
  for (const double s : {0.5 - offset, 0.5 + offset})
    for (const double t : {0.5 - offset, 0.5 + offset}) {
      const Eigen::Vector3d along_s = (1.0 - t) * (X[1] - X[0]) + t * (X[3] - X[2]);
      const Eigen::Vector3d along_t = (1.0 - s) * (X[2] - X[0]) + s * (X[3] - X[1]);
      add(s, t, 0.25 * along_s.cross(along_t).norm());
    }
}

/// Whether a triangle and the closed unit cube at `lower` have a point in common: no plane parts them (Akenine-Möller
/// 2001).
bool touches_cube(const Triangle& triangle, const Eigen::Vector3d& lower) {
  Triangle t;
  for (int c = 0; c < 3; ++c) t[c] = triangle[c] - lower - Eigen::Vector3d::Constant(0.5);
  const auto parted_along = [&](const Eigen::Vector3d& axis) {
    const double a = axis.dot(t[0]), b = axis.dot(t[1]), c = axis.dot(t[2]), reach = 0.5 * axis.cwiseAbs().sum();
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (parted_along(Eigen::Vector3d::Unit(axis))) return false;
    for (int c = 0; c < 3; ++c)
      if (parted_along(Eigen::Vector3d::Unit(axis).cross(t[(c + 1) % 3] - t[c]))) return false;
  }
  return !parted_along((t[1] - t[0]).cross(t[2] - t[0]));
}

}  // namespace

std::vector<SurfaceFacet> surface_facets(const BaseMesh& base) {
  std::vector<SurfaceFacet> facets;
  if (base.body) {
    const TriangleSurface& surface = base.body->surface;
    for (const auto& triangle : surface.triangles) {
      SurfaceFacet& facet = facets.emplace_back(SurfaceFacet{3, {}});
      for (int c = 0; c < 3; ++c) facet.corners[c] = surface.vertices.col(triangle[c]);
    }
    return facets;
  }
  for (const BaseFace& face : boundary_faces(base)) {
    SurfaceFacet& facet = facets.emplace_back(SurfaceFacet{face_corner_count(base.shape), {}, face});
    for (int c = 0; c < facet.corner_count; ++c)
      facet.corners[c] = base.nodes.col(base.cells[face.cell][face_corners(base.shape, face.face)[c]]);
  }
  return facets;
}

Selected select_facets(const std::vector<SurfaceFacet>& facets, const Selection& selection) {
  const Eigen::Matrix3Xd centres = centres_of(facets);
  const double slack = selection_slack(centres);
  const auto* patch = std::get_if<PatchSelection>(&selection);
  if (!patch) return select_points(centres, selection, slack);
  return select_points(centres, PatchSelection{nearest_point(facets, patch->point), patch->radius}, slack);
}

std::vector<SurfacePoint> surface_points(const BaseMesh& base, const std::vector<SurfaceFacet>& facets,
                                         const std::vector<int>& numbers) {
  std::vector<SurfacePoint> points;
  if (!base.body) {
    for (const int i : numbers) add_face(base.shape, facets[i], points);
    return points;
  }
  const LatticeCells cells(*base.body);
  const double half_cell = 0.5 * base.body->cell_size.minCoeff();
  for (const int i : numbers)
    add_immersed_triangle(cells, {facets[i].corners[0], facets[i].corners[1], facets[i].corners[2]}, half_cell, points);
  return points;
}

std::vector<int> touched_cells(const BaseMesh& base, const std::vector<SurfaceFacet>& facets,
                               const std::vector<int>& numbers) {
  const LatticeCells lattice(*base.body);
  std::vector<int> touched;
  for (const int i : numbers) {
    Triangle t;
    for (int c = 0; c < 3; ++c) t[c] = lattice.lattice_coordinates(facets[i].corners[c]);
    // One cell more on each side than the bounding box needs: the test itself says what is touched.
    const Eigen::Vector3d low = t[0].cwiseMin(t[1]).cwiseMin(t[2]), high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    std::array<int, 3> first, last;
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = std::max(0, static_cast<int>(std::floor(low[axis])) - 1);
      last[axis] = std::min(base.body->lattice_cells[axis] - 1, static_cast<int>(std::floor(high[axis])) + 1);
    }
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x)
          if (const int cell = lattice.at({x, y, z}); cell >= 0 && touches_cube(t, Eigen::Vector3d(x, y, z)))
            touched.push_back(cell);
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  return touched;
}

}  // namespace finegauge
