#include "core/scene/surface_check.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "core/scene/scene_error.hpp"
#include "core/scene/surface_defects.hpp"
#include "core/scene/surface_edges.hpp"
#include "core/scene/surface_intersections.hpp"
#include "core/scene/surface_repair.hpp"
#include "core/scene/surface_shells.hpp"

namespace finegauge {
namespace {

constexpr std::size_t most_pairs = 100000;    // of intersecting triangles, counted
constexpr int most_shells = 1000;             // each is compared with each
constexpr int most_split_passes = 20;         // flat triangles side by side need one each
constexpr double least_volume_share = 1e-12;  // of (area)^(3/2): rounding

struct Check {
  std::string name;
  CheckedSurface checked;
  std::vector<int> numbers;  ///< of the triangles left, as given

  [[noreturn]] void refuse(const std::string& words) const { throw SceneError(name + ": surface: " + words); }
  void refuse_if(const std::string& words) const {
    if (!words.empty()) refuse(words);
  }
  void note(std::string words) { checked.notes.push_back(std::move(words)); }

  std::string triangle_words(int t) const {
    const auto& corners = checked.surface.triangles[static_cast<std::size_t>(t)];
    const auto& x = checked.surface.vertices;
    return std::to_string(numbers[static_cast<std::size_t>(t)]) + " near " +
           point_words((x.col(corners[0]) + x.col(corners[1]) + x.col(corners[2])) / 3.0);
  }
};

void repair_vertices(Check& check) {
  TriangleSurface& surface = check.checked.surface;
  if (const int unused = drop_unused_vertices(surface); unused > 0)
    check.note("dropped " + counted(static_cast<std::size_t>(unused), "vertex that no triangle uses",
                                    "vertices that no triangle uses"));
  check.refuse_if(coordinate_defect(surface));
  if (const MergedVertices merged = merge_equal_vertices(surface); merged.count > 0)
    check.note("merged " +
               counted(static_cast<std::size_t>(merged.count), "vertex that equals another exactly, at ",
                       "vertices that equal another exactly, the first at ") +
               point_words(merged.first));
}

void repair_triangles(Check& check) {
  TriangleSurface& surface = check.checked.surface;
  int collapsed = drop_collapsed_triangles(surface, check.numbers), split = 0;
  std::vector<FlatTriangle> flat = flat_triangles(surface);
  for (int pass = 0; pass < most_split_passes && !flat.empty(); ++pass) {
    const int changed = split_at_flat_triangles(surface, flat);
    if (changed == 0) break;
    split += changed;
    flat = flat_triangles(surface);
  }
  if (!flat.empty())
    check.refuse("found " + counted(flat.size(), "triangle", "triangles") +
                 " of no area whose vertices differ, at whose long side there is no single neighbour to split: " +
                 check.triangle_words(flat.front().triangle) + "; allowed triangles with an area");
  if (collapsed > 0)
    check.note("dropped " + counted(static_cast<std::size_t>(collapsed), "triangle that names a vertex twice",
                                    "triangles that name a vertex twice"));
  if (split > 0)
    check.note("took out " + counted(static_cast<std::size_t>(split), "triangle", "triangles") +
               " of no area by splitting the neighbour at its long side");
  drop_unused_vertices(surface);
  if (surface.triangles.empty()) check.refuse("found no triangle with an area, allowed a closed surface");
}

void check_intersections(const Check& check) {
  const Intersections found = intersecting_triangles(check.checked.surface, most_pairs);
  const auto& pairs = found.pairs;
  if (pairs.empty()) return;
  std::string first;
  for (std::size_t i = 0; i < pairs.size() && i < 3; ++i)
    first += (i == 0 ? "" : "; ") + check.triangle_words(pairs[i][0]) + " and " + check.triangle_words(pairs[i][1]);
  check.refuse("found " + std::string(found.all ? "" : "more than ") +
               counted(pairs.size(), "pair of triangles that intersect", "pairs of triangles that intersect") +
               " (self-intersection): " + first + (pairs.size() > 3 ? "; ..." : "") +
               "; allowed triangles that meet at shared vertices and edges alone");
}

/// Vertices at which the surface touches itself: more than one fan of triangles around them.
void note_touching(Check& check, const std::vector<SurfaceEdge>& edges) {
  const TriangleSurface& surface = check.checked.surface;
  std::vector<int> corners(static_cast<std::size_t>(surface.vertices.cols()), 0);
  // Around a vertex each fan has as many edges as triangles: union the corners of a vertex across its edges.
  std::vector<int> parent(3 * surface.triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i)
      i = parent[static_cast<std::size_t>(i)] = parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(i)])];
    return i;
  };
  const auto corner_at = [&](int triangle, int vertex) {
    const auto& of = surface.triangles[static_cast<std::size_t>(triangle)];
    return 3 * triangle + static_cast<int>(std::find(of.begin(), of.end(), vertex) - of.begin());
  };
  for (std::size_t i = 0; i + 1 < edges.size(); i += 2)  // closed: edges stand in pairs
    for (const int vertex : {edges[i].low, edges[i].high}) {
      const int a = root(corner_at(edges[i].triangle, vertex)), b = root(corner_at(edges[i + 1].triangle, vertex));
      parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      if (const int i = static_cast<int>(3 * t + k); root(i) == i)
        ++corners[static_cast<std::size_t>(surface.triangles[t][k])];
  std::size_t count = 0;
  int first = -1;
  for (std::size_t v = 0; v < corners.size(); ++v)
    if (corners[v] > 1 && ++count == 1) first = static_cast<int>(v);
  if (count > 0)
    check.note("the surface touches itself at " + counted(count, "vertex", "vertices") + ", the first at " +
               point_words(surface.vertices.col(first)));
}

/// Shells from outside to inside are by turns the outside of a body and a cavity; turns those that are inside out with
/// all that is in them.
void check_shells(Check& check, const SurfacePieces& pieces) {
  TriangleSurface& surface = check.checked.surface;
  if (pieces.count > most_shells)
    check.refuse("found " + std::to_string(pieces.count) + " separate shells, allowed at most " +
                 std::to_string(most_shells));
  std::vector<Shell> shells = surface_shells(surface, pieces);
  for (const Shell& shell : shells)
    if (!(std::abs(shell.volume) > least_volume_share * shell.area * std::sqrt(shell.area)))
      check.refuse("found a shell of " + counted(shell.triangles.size(), "triangle", "triangles") +
                   " that encloses no volume, with triangle " + check.triangle_words(shell.triangles.front()) +
                   "; allowed a closed surface around a volume");

  std::vector<int> inside_out;
  for (std::size_t s = 0; s < shells.size(); ++s) {
    const auto& around = shells[s].around;
    const auto outermost =
        around.empty() ? s : static_cast<std::size_t>(*std::find_if(around.begin(), around.end(), [&](int other) {
          return shells[static_cast<std::size_t>(other)].around.empty();
        }));
    if (shells[outermost].volume < 0.0) inside_out.push_back(static_cast<int>(s));
  }
  for (const int s : inside_out) {
    Shell& shell = shells[static_cast<std::size_t>(s)];
    shell.volume = -shell.volume;
    for (const int t : shell.triangles) {
      auto& corners = surface.triangles[static_cast<std::size_t>(t)];
      std::swap(corners[1], corners[2]);
    }
  }
  std::size_t cavities = 0;
  for (const Shell& shell : shells) {
    const bool cavity = shell.around.size() % 2 == 1;
    cavities += cavity;
    if (cavity != (shell.volume < 0.0))
      check.refuse("found a shell inside " + counted(shell.around.size(), "other", "others") +
                   " that is turned as the one around it, with triangle " +
                   check.triangle_words(shell.triangles.front()) +
                   "; allowed cavities, turned the other way, or one body");
  }
  if (inside_out.size() == shells.size())
    check.note("turned all triangles: the surface was inside out");
  else if (!inside_out.empty())
    check.note("turned " + counted(inside_out.size(), "shell", "shells") + " of " + std::to_string(shells.size()) +
               ": inside out, the first with triangle " +
               check.triangle_words(shells[static_cast<std::size_t>(inside_out.front())].triangles.front()));
  if (shells.size() > 1)
    check.note("found " + std::to_string(shells.size()) + " separate shells, " + std::to_string(cavities) +
               " of them around cavities");
}

}  // namespace

CheckedSurface check_surface(TriangleSurface surface, const std::string& name) {
  Check check{name, {std::move(surface), {}}, {}};
  check.numbers.resize(check.checked.surface.triangles.size());
  std::iota(check.numbers.begin(), check.numbers.end(), 0);
  repair_vertices(check);
  repair_triangles(check);
  check.refuse_if(duplicate_defect(check.checked.surface, check.numbers));
  const std::vector<SurfaceEdge> edges = surface_edges(check.checked.surface.triangles);
  check.refuse_if(edge_defect(check.checked.surface, edges, check.numbers));
  check_intersections(check);
  note_touching(check, edges);
  check_shells(check, connected_pieces(edges, check.checked.surface.triangles.size()));
  return std::move(check.checked);
}

}  // namespace finegauge
