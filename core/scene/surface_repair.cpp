#include "core/scene/surface_repair.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>

#include "core/scene/surface_edges.hpp"

namespace finegauge {
namespace {

bool is_collapsed(const std::array<int, 3>& corners) {
  return corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
}

}  // namespace

int drop_unused_vertices(TriangleSurface& surface) {
  std::vector<int> number(static_cast<std::size_t>(surface.vertices.cols()), -1);
  for (const auto& corners : surface.triangles)
    for (const int vertex : corners) number[static_cast<std::size_t>(vertex)] = 0;
  int used = 0;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] < 0) continue;
    surface.vertices.col(used) = surface.vertices.col(static_cast<Eigen::Index>(v));
    number[v] = used++;
  }
  surface.vertices.conservativeResize(Eigen::NoChange, used);
  for (auto& corners : surface.triangles)
    for (int& vertex : corners) vertex = number[static_cast<std::size_t>(vertex)];
  return static_cast<int>(number.size()) - used;
}

MergedVertices merge_equal_vertices(TriangleSurface& surface) {
  const auto& x = surface.vertices;
  std::vector<int> sorted(static_cast<std::size_t>(x.cols())), number(sorted.size());
  std::iota(sorted.begin(), sorted.end(), 0);
  std::sort(sorted.begin(), sorted.end(), [&](int a, int b) {
    return std::tie(x(0, a), x(1, a), x(2, a), a) < std::tie(x(0, b), x(1, b), x(2, b), b);
  });
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const int here = sorted[i];
    const bool same = i > 0 && x.col(here) == x.col(sorted[i - 1]);
    number[static_cast<std::size_t>(here)] = same ? number[static_cast<std::size_t>(sorted[i - 1])] : here;
  }
  MergedVertices merged;
  int kept = 0;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] != static_cast<int>(v)) {  // of one before it, which has its new number already
      if (merged.count++ == 0) merged.first = x.col(static_cast<Eigen::Index>(v));
      number[v] = number[static_cast<std::size_t>(number[v])];
      continue;
    }
    surface.vertices.col(kept) = surface.vertices.col(static_cast<Eigen::Index>(v));
    number[v] = kept++;
  }
  surface.vertices.conservativeResize(Eigen::NoChange, kept);
  for (auto& corners : surface.triangles)
    for (int& vertex : corners) vertex = number[static_cast<std::size_t>(vertex)];
  return merged;
}

int drop_collapsed_triangles(TriangleSurface& surface, std::vector<int>& numbers) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (is_collapsed(surface.triangles[t])) continue;
    surface.triangles[kept] = surface.triangles[t];
    numbers[kept++] = numbers[t];
  }
  const auto dropped = static_cast<int>(surface.triangles.size() - kept);
  surface.triangles.resize(kept);
  numbers.resize(kept);
  return dropped;
}

int split_at_flat_triangles(TriangleSurface& surface, const std::vector<FlatTriangle>& flat) {
  if (flat.empty()) return 0;
  const std::vector<SurfaceEdge> edges = surface_edges(surface.triangles);
  std::vector<std::uint8_t> changed(surface.triangles.size(), 0);
  int count = 0;
  for (const auto& [triangle, middle] : flat) {
    auto& here = surface.triangles[static_cast<std::size_t>(triangle)];
    const auto m = static_cast<std::size_t>(middle);
    const int b = here[m], from = here[(m + 1) % 3], to = here[(m + 2) % 3];  // the long side is from - to
    const auto key = [](const SurfaceEdge& edge) { return std::pair(edge.low, edge.high); };
    const std::pair wanted(std::min(from, to), std::max(from, to));
    const auto first = std::lower_bound(edges.begin(), edges.end(), wanted,
                                        [&](const SurfaceEdge& edge, const auto& value) { return key(edge) < value; });
    const auto past = std::upper_bound(first, edges.end(), wanted,
                                       [&](const auto& value, const SurfaceEdge& edge) { return value < key(edge); });
    if (past - first != 2 || first[0].forward == first[1].forward) continue;
    const int other = first[0].triangle == triangle ? first[1].triangle : first[0].triangle;
    auto& beside = surface.triangles[static_cast<std::size_t>(other)];
    std::uint8_t& here_changed = changed[static_cast<std::size_t>(triangle)];
    std::uint8_t& beside_changed = changed[static_cast<std::size_t>(other)];
    const int apex =
        *std::find_if(beside.begin(), beside.end(), [&](int vertex) { return vertex != from && vertex != to; });
    if (here_changed || beside_changed || apex == b) continue;
    beside = {b, from, apex};
    here = {b, apex, to};
    here_changed = beside_changed = 1;
    ++count;
  }
  return count;
}

}  // namespace finegauge
