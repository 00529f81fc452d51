#include "core/scene/surface_intersections.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <numeric>

// Of CGAL the kernel alone, which is LGPL; its own self-intersection test (Polygon mesh processing, GPL) wants a
// halfedge structure, which a surface that touches itself at a vertex cannot have.
// Compiled apart with -frounding-math, which CGAL's interval arithmetic needs.

namespace finegauge {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Corners = std::array<int, 3>;

Point point(const TriangleSurface& surface, int vertex) {
  return {surface.vertices(0, vertex), surface.vertices(1, vertex), surface.vertices(2, vertex)};
}

Kernel::Triangle_3 whole(const TriangleSurface& surface, const Corners& corners) {
  return {point(surface, corners[0]), point(surface, corners[1]), point(surface, corners[2])};
}

/// The side across a vertex.
Kernel::Segment_3 side_across(const TriangleSurface& surface, const Corners& corners, int vertex) {
  const auto k = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), vertex) - corners.begin());
  return {point(surface, corners[(k + 1) % 3]), point(surface, corners[(k + 2) % 3])};
}

/// Whether triangles that share two vertices lie in one plane on one side of that edge.
bool overlap_at_edge(const TriangleSurface& surface, const Corners& a, const Corners& b) {
  std::array<int, 2> edge{};
  int in_a = -1, in_b = -1;
  std::size_t shared = 0;
  for (const int vertex : a)
    if (std::find(b.begin(), b.end(), vertex) != b.end())
      edge[shared++] = vertex;
    else
      in_a = vertex;
  for (const int vertex : b)
    if (std::find(a.begin(), a.end(), vertex) == a.end()) in_b = vertex;
  const Point p = point(surface, edge[0]), q = point(surface, edge[1]);
  const Point r = point(surface, in_a), s = point(surface, in_b);
  return CGAL::coplanar(p, q, r, s) && CGAL::coplanar_orientation(p, q, r, s) == CGAL::POSITIVE;
}

/// Whether two triangles have more in common than the vertices that they share.
bool intersect(const TriangleSurface& surface, const Corners& a, const Corners& b) {
  int shared = 0, vertex = -1;
  for (const int corner : a)
    if (std::find(b.begin(), b.end(), corner) != b.end()) {
      ++shared;
      vertex = corner;
    }
  if (shared == 0) return CGAL::do_intersect(whole(surface, a), whole(surface, b));
  if (shared >= 2) return overlap_at_edge(surface, a, b);
  // What they share beyond the vertex begins there and ends at the far side of one of them.
  return CGAL::do_intersect(whole(surface, a), side_across(surface, b, vertex)) ||
         CGAL::do_intersect(whole(surface, b), side_across(surface, a, vertex));
}

struct Box {
  Eigen::Vector3d low, high;
  bool meets(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

/// A binary tree of boxes over the triangles: node n covers triangles [first, past) of `order`.
struct Node {
  Box box;
  int first, past;
  int child = -1;  ///< the first of two, one behind the other; -1 at a leaf
};

struct Search {
  const TriangleSurface& surface;
  std::size_t most_pairs;
  std::vector<Box> boxes;  ///< of the triangles
  std::vector<int> order;
  std::vector<Node> nodes;
  Intersections found;
};

constexpr int leaf_size = 8;

void build(Search& search, int first, int past) {
  search.nodes.push_back({{}, first, past});
  for (std::size_t n = 0; n < search.nodes.size(); ++n) {
    Node node = search.nodes[n];
    node.box = search.boxes[static_cast<std::size_t>(search.order[static_cast<std::size_t>(node.first)])];
    for (int i = node.first; i < node.past; ++i) {
      const Box& box = search.boxes[static_cast<std::size_t>(search.order[static_cast<std::size_t>(i)])];
      node.box.low = node.box.low.cwiseMin(box.low);
      node.box.high = node.box.high.cwiseMax(box.high);
    }
    if (node.past - node.first > leaf_size) {
      int axis = 0;
      (node.box.high - node.box.low).maxCoeff(&axis);
      const auto middle = search.order.begin() + (node.first + node.past) / 2;
      std::nth_element(search.order.begin() + node.first, middle, search.order.begin() + node.past, [&](int a, int b) {
        const Box &at_a = search.boxes[static_cast<std::size_t>(a)], &at_b = search.boxes[static_cast<std::size_t>(b)];
        const double centre_a = at_a.low[axis] + at_a.high[axis], centre_b = at_b.low[axis] + at_b.high[axis];
        return centre_a != centre_b ? centre_a < centre_b : a < b;
      });
      node.child = static_cast<int>(search.nodes.size());
      const auto split = static_cast<int>(middle - search.order.begin());
      search.nodes.push_back({{}, node.first, split});
      search.nodes.push_back({{}, split, node.past});
    }
    search.nodes[n] = node;
  }
}

void test(Search& search, int a, int b) {
  if (!search.boxes[static_cast<std::size_t>(a)].meets(search.boxes[static_cast<std::size_t>(b)])) return;
  const auto& triangles = search.surface.triangles;
  if (!intersect(search.surface, triangles[static_cast<std::size_t>(a)], triangles[static_cast<std::size_t>(b)]))
    return;
  if (search.found.pairs.size() == search.most_pairs)
    search.found.all = false;
  else
    search.found.pairs.push_back({std::min(a, b), std::max(a, b)});
}

/// All pairs of a triangle below node m and one below node n; each pair once where m == n.
void walk(Search& search, int m, int n) {
  if (!search.found.all) return;
  const Node &a = search.nodes[static_cast<std::size_t>(m)], &b = search.nodes[static_cast<std::size_t>(n)];
  if (!a.box.meets(b.box)) return;
  if (a.child < 0 && b.child < 0) {
    for (int i = a.first; i < a.past; ++i)
      for (int k = m == n ? i + 1 : b.first; k < b.past; ++k)
        test(search, search.order[static_cast<std::size_t>(i)], search.order[static_cast<std::size_t>(k)]);
  } else if (m == n) {
    walk(search, a.child, a.child);
    walk(search, a.child, a.child + 1);
    walk(search, a.child + 1, a.child + 1);
  } else if (b.child < 0 || (a.child >= 0 && a.past - a.first >= b.past - b.first)) {
    walk(search, a.child, n);
    walk(search, a.child + 1, n);
  } else {
    walk(search, m, b.child);
    walk(search, m, b.child + 1);
  }
}

}  // namespace

std::vector<FlatTriangle> flat_triangles(const TriangleSurface& surface) {
  std::vector<FlatTriangle> flat;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const auto& corners = surface.triangles[static_cast<std::size_t>(t)];
    const Point p = point(surface, corners[0]), q = point(surface, corners[1]), r = point(surface, corners[2]);
    if (!CGAL::collinear(p, q, r)) continue;
    const int middle = CGAL::collinear_are_ordered_along_line(p, q, r)   ? 1
                       : CGAL::collinear_are_ordered_along_line(q, r, p) ? 2
                                                                         : 0;
    flat.push_back({t, middle});
  }
  return flat;
}

Intersections intersecting_triangles(const TriangleSurface& surface, std::size_t most_pairs) {
  if (surface.triangles.empty()) return {};
  Search search{surface, most_pairs, {}, std::vector<int>(surface.triangles.size()), {}, {}};
  for (const auto& [a, b, c] : surface.triangles) {
    const Eigen::Vector3d p = surface.vertices.col(a), q = surface.vertices.col(b), r = surface.vertices.col(c);
    search.boxes.push_back({p.cwiseMin(q).cwiseMin(r), p.cwiseMax(q).cwiseMax(r)});
  }
  std::iota(search.order.begin(), search.order.end(), 0);
  build(search, 0, static_cast<int>(surface.triangles.size()));
  walk(search, 0, 0);
  std::sort(search.found.pairs.begin(), search.found.pairs.end());
  return std::move(search.found);
}

}  // namespace finegauge
