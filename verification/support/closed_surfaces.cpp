#include "verification/support/closed_surfaces.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace finegauge {
namespace {

/// Vertices by a key that all triangles around them agree on, so that a position is computed once.
template <class Key>
class SharedVertices {
 public:
  template <class Position>
  int number(const Key& key, const Position& position) {
    const auto [found, fresh] = numbers_.try_emplace(key, static_cast<int>(positions_.size()));
    if (fresh) positions_.push_back(position());
    return found->second;
  }
  Eigen::Matrix3Xd matrix() const {
    Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(positions_.size()));
    for (std::size_t v = 0; v < positions_.size(); ++v) vertices.col(static_cast<Eigen::Index>(v)) = positions_[v];
    return vertices;
  }

 private:
  std::map<Key, int> numbers_;
  std::vector<Eigen::Vector3d> positions_;
};

std::array<Eigen::Vector3d, 12> icosahedron_corners() {
  const double g = std::numbers::phi;
  std::array<Eigen::Vector3d, 12> corners;
  int c = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const double a : {-1.0, 1.0})
      for (const double b : {-g, g}) {
        corners[c].setZero();
        corners[c][(axis + 1) % 3] = a;
        corners[c++][(axis + 2) % 3] = b;
      }
  return corners;
}

/// Unit sphere. Vertex key: the face's corners that carry weight, ascending, and their weights.
TriangleSurface unit_icosphere(int divisions) {
  const auto corners = icosahedron_corners();
  TriangleSurface surface;
  SharedVertices<std::array<int, 6>> vertices;
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c) {
        const auto near = [&](int p, int q) { return (corners[p] - corners[q]).squaredNorm() < 5.0; };  // edges: 4
        if (!near(a, b) || !near(b, c) || !near(a, c)) continue;
        const bool outward = corners[a].dot(corners[b].cross(corners[c])) > 0.0;
        const std::array<int, 3> face = {a, outward ? b : c, outward ? c : b};
        const auto vertex = [&](int i, int j) {
          const std::array<int, 3> weight = {divisions - i - j, i, j};
          const std::array<int, 3> order = {0, outward ? 1 : 2, outward ? 2 : 1};  // ascending by corner
          std::array<int, 6> key = {-1, -1, -1, 0, 0, 0};
          int used = 0;
          for (const int k : order)
            if (weight[k] > 0) {
              key[used] = face[k];
              key[3 + used++] = weight[k];
            }
          return vertices.number(key, [&] {
            Eigen::Vector3d X = Eigen::Vector3d::Zero();
            for (int k = 0; k < used; ++k) X += key[3 + k] * corners[key[k]];
            return Eigen::Vector3d(X / X.norm());
          });
        };
        for (int i = 0; i < divisions; ++i)
          for (int j = 0; i + j < divisions; ++j) {
            surface.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)});
            if (i + j + 1 < divisions)
              surface.triangles.push_back({vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
          }
      }
  surface.vertices = vertices.matrix();
  return surface;
}

}  // namespace

TriangleSurface icosphere(int divisions, double radius, const Eigen::Vector3d& centre) {
  return closed_ellipsoid(divisions, Eigen::Vector3d::Constant(radius), centre);
}

TriangleSurface closed_ellipsoid(int divisions, const Eigen::Vector3d& half_axes, const Eigen::Vector3d& centre) {
  return affine_image(half_axes.asDiagonal(), centre, unit_icosphere(divisions));
}

TriangleSurface closed_box(const Eigen::Vector3d& size, const Eigen::Vector3d& centre, const Eigen::Matrix3d& turn,
                           int divisions) {
  TriangleSurface surface;
  SharedVertices<std::array<int, 3>> vertices;
  const auto vertex = [&](const std::array<int, 3>& at) {
    return vertices.number(at, [&] {
      Eigen::Vector3d X;
      for (int axis = 0; axis < 3; ++axis) X[axis] = (2 * at[axis] - divisions) * size[axis] / (2 * divisions);
      return Eigen::Vector3d(centre + turn * X);
    });
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, 1})
      for (int i = 0; i < divisions; ++i)
        for (int j = 0; j < divisions; ++j) {
          const auto corner = [&](int a, int b) {
            std::array<int, 3> at;
            at[axis] = side * divisions;
            at[(axis + 1) % 3] = i + a;
            at[(axis + 2) % 3] = j + b;
            return vertex(at);
          };
          std::array<int, 3> low = {corner(0, 0), corner(1, 0), corner(1, 1)};
          std::array<int, 3> high = {corner(0, 0), corner(1, 1), corner(0, 1)};
          if (side == 0) {
            std::swap(low[1], low[2]);
            std::swap(high[1], high[2]);
          }
          surface.triangles.push_back(low);
          surface.triangles.push_back(high);
        }
  surface.vertices = vertices.matrix();
  return surface;
}

TriangleSurface closed_torus(double ring_radius, double tube_radius, int ring_divisions, int tube_divisions,
                             const Eigen::Vector3d& centre) {
  TriangleSurface surface;
  surface.vertices.resize(3, ring_divisions * tube_divisions);
  const auto vertex = [&](int i, int j) { return i % ring_divisions * tube_divisions + j % tube_divisions; };
  for (int i = 0; i < ring_divisions; ++i)
    for (int j = 0; j < tube_divisions; ++j) {
      const double ring = 2.0 * std::numbers::pi * i / ring_divisions;
      const double tube = 2.0 * std::numbers::pi * j / tube_divisions;
      const double r = ring_radius + tube_radius * std::cos(tube);
      surface.vertices.col(vertex(i, j)) =
          centre + Eigen::Vector3d(r * std::cos(ring), r * std::sin(ring), tube_radius * std::sin(tube));
      surface.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      surface.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  return surface;
}

TriangleSurface closed_tetrahedron(const std::array<Eigen::Vector3d, 4>& corners) {
  TriangleSurface surface;
  surface.vertices.resize(3, 4);
  for (int c = 0; c < 4; ++c) surface.vertices.col(c) = corners[c];
  const auto edge = [&](int c) -> Eigen::Vector3d { return corners[c] - corners[0]; };
  surface.triangles = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  return edge(1).dot(edge(2).cross(edge(3))) > 0.0 ? surface : turned_inside_out(std::move(surface));
}

TriangleSurface affine_image(const Eigen::Matrix3d& A, const Eigen::Vector3d& b, TriangleSurface surface) {
  for (auto X : surface.vertices.colwise()) X = (A * X + b).eval();
  return A.determinant() < 0.0 ? turned_inside_out(std::move(surface)) : surface;
}

TriangleSurface turned_inside_out(TriangleSurface surface) {
  for (auto& triangle : surface.triangles) std::swap(triangle[1], triangle[2]);
  return surface;
}

double winding_number(const TriangleSurface& surface, const Eigen::Vector3d& X) {
  double angle = 0.0;
  for (int triangle = 0; triangle < surface.triangle_count(); ++triangle) {
    const Eigen::Matrix3d r = triangle_corners(surface, triangle).colwise() - X;
    const Eigen::Vector3d a = r.col(0), b = r.col(1), c = r.col(2);
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4.0 * std::numbers::pi);
}

Eigen::Matrix3d oblique_turn() {
  return Eigen::AngleAxisd(std::numbers::pi / 6.0, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
}

}  // namespace finegauge
