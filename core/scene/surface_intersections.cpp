#include "core/scene/surface_intersections.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

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
  void hold(const Box& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
};

struct Search {
  const TriangleSurface& surface;
  std::size_t most_pairs;
  double slack;            ///< above the round-off of turned coordinates [length of the file]
  std::vector<Box> boxes;  ///< of the triangles
  Intersections found;
};

int shared_vertices(const Corners& a, const Corners& b) {
  return static_cast<int>(std::count_if(a.begin(), a.end(), [&](int v) { return std::ranges::find(b, v) != b.end(); }));
}

void decide(Search& search, int a, int b) {
  ++search.found.decided;
  const auto& triangles = search.surface.triangles;
  if (!intersect(search.surface, triangles[static_cast<std::size_t>(a)], triangles[static_cast<std::size_t>(b)]))
    return;
  if (search.found.pairs.size() == search.most_pairs)
    search.found.all = false;
  else
    search.found.pairs.push_back({std::min(a, b), std::max(a, b)});
}

// Triangles that share a vertex meet in a ray from it or not at all: seen from there they are arcs on a sphere.

/// An arc with the box around it. The arc bulges beyond its ends by less than the square of their distance.
struct Arc {
  Box box;
  int triangle;
};

/// Pairs of arcs whose boxes meet, by halves along the longest axis. An arc that reaches far around stays in both
/// halves' way, so that wide arcs side by side cost a comparison of boxes each with each.
template <class Visit>
void visit_meeting_arcs(std::vector<Arc>& arcs, std::size_t first, std::size_t past, const Visit& visit) {
  const auto begin = arcs.begin() + static_cast<std::ptrdiff_t>(first),
             end = arcs.begin() + static_cast<std::ptrdiff_t>(past);
  if (past - first <= 8) {
    for (auto a = begin; a != end; ++a)
      for (auto b = a + 1; b != end; ++b)
        if (a->box.meets(b->box)) visit(a->triangle, b->triangle);
    return;
  }
  Box around = begin->box;
  for (auto a = begin; a != end; ++a) around.hold(a->box);
  int axis = 0;
  (around.high - around.low).maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](const Arc& a, const Arc& b) {
    const double at_a = a.box.low[axis] + a.box.high[axis], at_b = b.box.low[axis] + b.box.high[axis];
    return at_a != at_b ? at_a < at_b : a.triangle < b.triangle;
  });
  Box left = begin->box, right = middle->box;
  for (auto a = begin; a != middle; ++a) left.hold(a->box);
  for (auto a = middle; a != end; ++a) right.hold(a->box);
  // Pairs across: of the arcs that reach into the other half's box, sorted along the axis.
  std::vector<const Arc*> of_left, of_right;
  for (auto a = begin; a != middle; ++a)
    if (a->box.meets(right)) of_left.push_back(&*a);
  for (auto a = middle; a != end; ++a)
    if (a->box.meets(left)) of_right.push_back(&*a);
  for (const Arc* a : of_left)
    for (const Arc* b : of_right)
      if (a->box.meets(b->box)) visit(a->triangle, b->triangle);
  const auto split = static_cast<std::size_t>(middle - arcs.begin());
  visit_meeting_arcs(arcs, first, split, visit);
  visit_meeting_arcs(arcs, split, past, visit);
}

void search_stars(Search& search) {
  const auto& triangles = search.surface.triangles;
  const auto& x = search.surface.vertices;
  std::vector<std::vector<int>> star(static_cast<std::size_t>(x.cols()));
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int vertex : triangles[t]) star[static_cast<std::size_t>(vertex)].push_back(static_cast<int>(t));
  std::vector<Arc> arcs;
  for (int vertex = 0; vertex < static_cast<int>(star.size()) && search.found.all; ++vertex) {
    arcs.clear();
    for (const int t : star[static_cast<std::size_t>(vertex)]) {
      std::array<Eigen::Vector3d, 2> ends;
      std::size_t count = 0;
      for (const int corner : triangles[static_cast<std::size_t>(t)])
        if (corner != vertex) ends[count++] = (x.col(corner) - x.col(vertex)).stableNormalized();
      const double bulge = (ends[1] - ends[0]).squaredNorm() + 1e-14;
      arcs.push_back({{ends[0].cwiseMin(ends[1]).array() - bulge, ends[0].cwiseMax(ends[1]).array() + bulge}, t});
    }
    visit_meeting_arcs(arcs, 0, arcs.size(), [&](int a, int b) {
      const auto &of_a = triangles[static_cast<std::size_t>(a)], &of_b = triangles[static_cast<std::size_t>(b)];
      // Triangles at an edge stand in two stars.
      const bool first = std::ranges::none_of(
          of_a, [&](int corner) { return corner < vertex && std::ranges::find(of_b, corner) != of_b.end(); });
      if (first && search.found.all) decide(search, a, b);
    });
  }
}

// Triangles that share none: a tree of boxes, each turned as its triangles lie, since one along the axes says little of
// a sliver (the trees of Gottschalk, Lin & Manocha 1996).

struct TurnedBox {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns, orthonormal
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), half = Eigen::Vector3d::Zero();

  /// Compares along the axes of both: boxes that only a cross product of two axes parts count as meeting.
  bool meets(const TurnedBox& other) const {
    const Eigen::Vector3d between = other.centre - centre;
    const Eigen::Matrix3d cosines = (axes.transpose() * other.axes).cwiseAbs();
    return ((axes.transpose() * between).cwiseAbs().array() <= (half + cosines * other.half).array()).all() &&
           ((other.axes.transpose() * between).cwiseAbs().array() <= (other.half + cosines.transpose() * half).array())
               .all();
  }
};

/// Node n covers triangles [first, past) of `order`.
struct Node {
  TurnedBox box;
  int first, past;
  int child = -1;             ///< the first of two, one behind the other; -1 at a leaf
  std::array<int, 3> common;  ///< vertices that all its triangles have, -1 for none
};

struct Tree {
  std::vector<int> order;
  std::vector<Node> nodes;
};

/// Along the longest edges on the whole, and across, flat as the triangles are.
TurnedBox box_around(const Search& search, std::span<const int> triangles) {
  const auto corners_of = [&](int t) {
    const auto& [a, b, c] = search.surface.triangles[static_cast<std::size_t>(t)];
    const auto& x = search.surface.vertices;
    return std::array<Eigen::Vector3d, 3>{x.col(a), x.col(b), x.col(c)};
  };
  Eigen::Vector3d along = Eigen::Vector3d::Zero(), normal = along;
  for (const int t : triangles) {
    const auto [p, q, r] = corners_of(t);
    std::array<Eigen::Vector3d, 3> edges = {q - p, r - q, p - r};
    const Eigen::Vector3d longest =
        *std::ranges::max_element(edges, {}, [](const Eigen::Vector3d& edge) { return edge.squaredNorm(); });
    along += along.dot(longest) < 0.0 ? Eigen::Vector3d(-longest) : longest;
    normal += (q - p).cross(r - p);
  }
  TurnedBox box;
  box.axes.col(0) = along.squaredNorm() > 0.0 ? along.stableNormalized() : Eigen::Vector3d::UnitX();
  normal -= box.axes.col(0) * box.axes.col(0).dot(normal);
  box.axes.col(2) = normal.squaredNorm() > 0.0 ? normal.stableNormalized() : box.axes.col(0).unitOrthogonal();
  box.axes.col(2) = (box.axes.col(2) - box.axes.col(0) * box.axes.col(0).dot(box.axes.col(2))).normalized();
  box.axes.col(1) = box.axes.col(2).cross(box.axes.col(0));
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
  for (const int t : triangles)
    for (const Eigen::Vector3d& corner : corners_of(t)) {
      const Eigen::Vector3d at = box.axes.transpose() * corner;
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
  box.centre = box.axes * (0.5 * (low + high));
  box.half = (0.5 * (high - low)).array() + search.slack;
  return box;
}

std::array<int, 3> common_vertices(const Search& search, std::span<const int> triangles) {
  std::array<int, 3> common = search.surface.triangles[static_cast<std::size_t>(triangles.front())];
  for (const int t : triangles)
    for (int& vertex : common)
      if (std::ranges::count(search.surface.triangles[static_cast<std::size_t>(t)], vertex) == 0) vertex = -1;
  return common;
}

constexpr int leaf_size = 8;

Tree build_tree(const Search& search, std::vector<int> order) {
  Tree tree{std::move(order), {}};
  const auto centre = [&](int t, int axis) {
    const auto& [a, b, c] = search.surface.triangles[static_cast<std::size_t>(t)];
    const auto& x = search.surface.vertices;
    return x(axis, a) + x(axis, b) + x(axis, c);
  };
  tree.nodes.push_back({{}, 0, static_cast<int>(tree.order.size()), -1, {}});
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    Node node = tree.nodes[n];
    const std::span<int> part =
        std::span(tree.order)
            .subspan(static_cast<std::size_t>(node.first), static_cast<std::size_t>(node.past - node.first));
    node.box = box_around(search, part);
    node.common = common_vertices(search, part);
    if (node.past - node.first > leaf_size) {
      int axis = 0;
      double widest = -1.0;
      for (int k = 0; k < 3; ++k) {
        const auto [low, high] = std::ranges::minmax(part, {}, [&](int t) { return centre(t, k); });
        if (const double width = centre(high, k) - centre(low, k); width > widest) {
          widest = width;
          axis = k;
        }
      }
      const auto middle = part.begin() + static_cast<std::ptrdiff_t>(part.size() / 2);
      std::nth_element(part.begin(), middle, part.end(),
                       [&](int a, int b) { return std::pair(centre(a, axis), a) < std::pair(centre(b, axis), b); });
      node.child = static_cast<int>(tree.nodes.size());
      const int split = node.first + static_cast<int>(part.size() / 2);
      tree.nodes.push_back({{}, node.first, split, -1, {}});
      tree.nodes.push_back({{}, split, node.past, -1, {}});
    }
    tree.nodes[n] = node;
  }
  return tree;
}

bool in_one_star(const Node& a, const Node& b) {
  return std::ranges::any_of(a.common,
                             [&](int vertex) { return vertex >= 0 && std::ranges::count(b.common, vertex) > 0; });
}

/// All pairs of a triangle below node m of one tree and one below node n of another or the same; each pair once where
/// the nodes are one. Those that share a vertex are left to search_stars.
void walk(Search& search, const Tree& of_a, int m, const Tree& of_b, int n) {
  const Node &a = of_a.nodes[static_cast<std::size_t>(m)], &b = of_b.nodes[static_cast<std::size_t>(n)];
  const bool same = &a == &b;
  if (!search.found.all || in_one_star(a, b) || !(same || a.box.meets(b.box))) return;
  if (a.child < 0 && b.child < 0) {
    const auto& triangles = search.surface.triangles;
    for (int i = a.first; i < a.past; ++i)
      for (int k = same ? i + 1 : b.first; k < b.past; ++k) {
        const int t = of_a.order[static_cast<std::size_t>(i)], u = of_b.order[static_cast<std::size_t>(k)];
        if (shared_vertices(triangles[static_cast<std::size_t>(t)], triangles[static_cast<std::size_t>(u)]) == 0 &&
            search.boxes[static_cast<std::size_t>(t)].meets(search.boxes[static_cast<std::size_t>(u)]))
          decide(search, t, u);
      }
  } else if (same) {
    walk(search, of_a, a.child, of_a, a.child);
    walk(search, of_a, a.child, of_a, a.child + 1);
    walk(search, of_a, a.child + 1, of_a, a.child + 1);
  } else if (b.child < 0 || (a.child >= 0 && a.past - a.first >= b.past - b.first)) {
    walk(search, of_a, a.child, of_b, n);
    walk(search, of_a, a.child + 1, of_b, n);
  } else {
    walk(search, of_a, m, of_b, b.child);
    walk(search, of_a, m, of_b, b.child + 1);
  }
}

/// Triangles around a vertex of many have a tree of their own, whose triangles never need to be compared.
void search_trees(Search& search) {
  constexpr int many = 32;
  const auto& triangles = search.surface.triangles;
  std::vector<int> valence(static_cast<std::size_t>(search.surface.vertices.cols()), 0);
  for (const auto& corners : triangles)
    for (const int vertex : corners) ++valence[static_cast<std::size_t>(vertex)];
  std::map<int, std::vector<int>> groups;  // by their vertex; -1 for all others
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const int vertex =
        *std::ranges::max_element(triangles[t], {}, [&](int v) { return valence[static_cast<std::size_t>(v)]; });
    groups[valence[static_cast<std::size_t>(vertex)] > many ? vertex : -1].push_back(static_cast<int>(t));
  }
  std::vector<Tree> trees;
  for (auto& [vertex, group] : groups) trees.push_back(build_tree(search, std::move(group)));
  for (std::size_t i = 0; i < trees.size(); ++i)
    for (std::size_t k = i; k < trees.size(); ++k) walk(search, trees[i], 0, trees[k], 0);
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
  Search search{surface, most_pairs, 1e-14 * surface.vertices.cwiseAbs().maxCoeff(), {}, {}};
  for (const auto& [a, b, c] : surface.triangles) {
    const Eigen::Vector3d p = surface.vertices.col(a), q = surface.vertices.col(b), r = surface.vertices.col(c);
    search.boxes.push_back({p.cwiseMin(q).cwiseMin(r), p.cwiseMax(q).cwiseMax(r)});
  }
  search_stars(search);
  search_trees(search);
  std::sort(search.found.pairs.begin(), search.found.pairs.end());
  return std::move(search.found);
}

}  // namespace finegauge
