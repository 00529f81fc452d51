#include "core/scene/surface_defects.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <sstream>
#include <tuple>

#include "core/scene/number_limits.hpp"

namespace finegauge {
namespace {

constexpr std::size_t most_shown = 3;
constexpr double slit_share = 1e-6;  // of the diagonal: what single precision or seven digits leave

/// The first items in words, "; " between them.
template <class Items, class Words>
std::string first_in_words(const Items& items, const Words& words) {
  std::string text;
  for (std::size_t i = 0; i < items.size() && i < most_shown; ++i) text += (i == 0 ? "" : "; ") + words(items[i]);
  return items.size() > most_shown ? text + "; ..." : text;
}

std::string edge_words(const TriangleSurface& surface, const SurfaceEdge& edge) {
  return "from " + point_words(surface.vertices.col(edge.low)) + " to " + point_words(surface.vertices.col(edge.high));
}

struct OpenEdge {
  std::array<std::int64_t, 3> place;  ///< of its middle, in a grid of twice the tolerance
  std::size_t index;
};

double diagonal(const TriangleSurface& surface) {
  return (surface.vertices.rowwise().maxCoeff() - surface.vertices.rowwise().minCoeff()).norm();
}

bool ends_coincide(const TriangleSurface& surface, const SurfaceEdge& a, const SurfaceEdge& b, double tolerance) {
  const auto near = [&](int v, int w) {
    return (surface.vertices.col(v) - surface.vertices.col(w)).norm() <= tolerance;
  };
  return (near(a.low, b.low) && near(a.high, b.high)) || (near(a.low, b.high) && near(a.high, b.low));
}

/// For each open edge another one whose ends coincide with its own within slit_share of the diagonal, else -1.
std::vector<int> slit_partners(const TriangleSurface& surface, const std::vector<SurfaceEdge>& open) {
  const double tolerance = slit_share * diagonal(surface);
  const Eigen::Vector3d low = surface.vertices.rowwise().minCoeff();
  std::vector<OpenEdge> sorted;
  const auto by_place = [](const OpenEdge& a, const OpenEdge& b) {
    return std::tie(a.place, a.index) < std::tie(b.place, b.index);
  };
  for (std::size_t i = 0; i < open.size(); ++i) {
    const Eigen::Vector3d middle = (surface.vertices.col(open[i].low) + surface.vertices.col(open[i].high)) / 2.0;
    OpenEdge& edge = sorted.emplace_back(OpenEdge{{}, i});
    for (std::size_t k = 0; k < 3; ++k)
      edge.place[k] =
          std::llround((middle[static_cast<Eigen::Index>(k)] - low[static_cast<Eigen::Index>(k)]) / (2.0 * tolerance));
  }
  std::sort(sorted.begin(), sorted.end(), by_place);
  std::vector<int> partner(open.size(), -1);
  for (const OpenEdge& edge : sorted)
    for (int neighbour = 0; neighbour < 27 && partner[edge.index] < 0; ++neighbour) {
      const std::array<std::int64_t, 3> place = {
          edge.place[0] + neighbour % 3 - 1, edge.place[1] + neighbour / 3 % 3 - 1, edge.place[2] + neighbour / 9 - 1};
      for (auto other = std::lower_bound(sorted.begin(), sorted.end(), OpenEdge{place, 0}, by_place);
           other != sorted.end() && other->place == place && partner[edge.index] < 0; ++other)
        if (other->index != edge.index && ends_coincide(surface, open[edge.index], open[other->index], tolerance))
          partner[edge.index] = static_cast<int>(other->index);
    }
  return partner;
}

std::string slit_words(const TriangleSurface& surface, const std::vector<SurfaceEdge>& open) {
  const std::vector<int> partner = slit_partners(surface, open);
  const auto slits = open.size() - static_cast<std::size_t>(std::count(partner.begin(), partner.end(), -1));
  if (slits == 0) return "";
  const auto first = std::find_if(partner.begin(), partner.end(), [](int p) { return p >= 0; });
  const SurfaceEdge& edge = open[static_cast<std::size_t>(first - partner.begin())];
  return "; " + std::to_string(slits) +
         " of them are slits: their ends coincide with those of another open edge within 1e-6 of the diagonal, the "
         "first is " +
         edge_words(surface, edge) + " and " + edge_words(surface, open[static_cast<std::size_t>(*first)]) +
         ": vertices written more than once, with slightly different coordinates; merge them by distance in a "
         "mesh editor";
}

}  // namespace

std::string point_words(const Eigen::Vector3d& point) {
  std::ostringstream words;
  words.precision(9);
  words << "(" << point.x() << ", " << point.y() << ", " << point.z() << ")";
  return words.str();
}

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string coordinate_defect(const TriangleSurface& surface) {
  for (int v = 0; v < surface.vertices.cols(); ++v)
    if (!surface.vertices.col(v).allFinite())
      return "found vertex " + std::to_string(v) + " at " + point_words(surface.vertices.col(v)) +
             ", allowed finite coordinates";
  if (surface.vertices.cols() == 0) return "found no triangle, allowed a closed surface";
  const double largest = surface.vertices.cwiseAbs().maxCoeff(), extent = diagonal(surface);
  if (extent >= least_magnitude && largest <= most_magnitude) return "";
  std::ostringstream words;
  words << "found coordinates up to " << largest << " over a diagonal of " << extent << ", allowed up to "
        << most_magnitude << " over " << least_magnitude << " or more";
  return words.str();
}

std::string duplicate_defect(const TriangleSurface& surface, const std::vector<int>& numbers) {
  struct Sorted {
    std::array<int, 3> corners;
    int triangle;
  };
  std::vector<Sorted> sorted;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    sorted.push_back({surface.triangles[t], static_cast<int>(t)});
    std::sort(sorted.back().corners.begin(), sorted.back().corners.end());
  }
  std::sort(sorted.begin(), sorted.end(), [](const Sorted& a, const Sorted& b) {
    return std::tie(a.corners, a.triangle) < std::tie(b.corners, b.triangle);
  });
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i].corners == sorted[i - 1].corners) pairs.push_back({sorted[i - 1].triangle, sorted[i].triangle});
  if (pairs.empty()) return "";
  const auto words = [&](const std::array<int, 2>& pair) {
    const auto& corners = surface.triangles[static_cast<std::size_t>(pair[0])];
    return std::to_string(numbers[static_cast<std::size_t>(pair[0])]) + " and " +
           std::to_string(numbers[static_cast<std::size_t>(pair[1])]) + " at " +
           point_words(surface.vertices.col(corners[0])) + ", " + point_words(surface.vertices.col(corners[1])) + ", " +
           point_words(surface.vertices.col(corners[2]));
  };
  return "found " + counted(pairs.size(), "triangle that repeats another", "triangles that repeat another") + ": " +
         first_in_words(pairs, words) + "; allowed each once";
}

std::string edge_defect(const TriangleSurface& surface, const std::vector<SurfaceEdge>& edges,
                        const std::vector<int>& numbers) {
  const auto number = [&](const SurfaceEdge& edge) {
    return std::to_string(numbers[static_cast<std::size_t>(edge.triangle)]);
  };
  std::vector<SurfaceEdge> open;
  std::vector<std::size_t> crowded, turned;  // in `edges`, the first of each
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    if (end - i == 1) open.push_back(edges[i]);
    if (end - i == 2 && edges[i].forward == edges[i + 1].forward) turned.push_back(i);
    if (end - i > 2) crowded.push_back(i);
  }
  if (!crowded.empty()) {
    const auto words = [&](std::size_t first) {
      std::string triangles;
      std::size_t count = 0;
      for (std::size_t i = first;
           i < edges.size() && edges[i].low == edges[first].low && edges[i].high == edges[first].high; ++i)
        if (++count <= 6) triangles += (count == 1 ? "" : ", ") + number(edges[i]);
      return edge_words(surface, edges[first]) + " of triangles " + triangles + (count > 6 ? ", ..." : "");
    };
    return "found " + counted(crowded.size(), "edge", "edges") +
           " of three or more triangles (not a manifold): " + first_in_words(crowded, words) +
           "; allowed a closed surface, two triangles at every edge";
  }
  if (!open.empty()) {
    const auto words = [&](const SurfaceEdge& edge) {
      return edge_words(surface, edge) + " of triangle " + number(edge);
    };
    return "found " + counted(open.size(), "open edge", "open edges") +
           " of one triangle: " + first_in_words(open, words) + slit_words(surface, open) +
           "; allowed a closed surface, two triangles at every edge";
  }
  if (!turned.empty()) {
    const auto words = [&](std::size_t i) {
      return edge_words(surface, edges[i]) + " of triangles " + number(edges[i]) + " and " + number(edges[i + 1]);
    };
    return "found " + counted(turned.size(), "edge", "edges") +
           " whose two triangles run through it in the same direction (inconsistent orientation): " +
           first_in_words(turned, words) +
           "; allowed opposite directions, all triangles counter-clockwise from outside";
  }
  return "";
}

}  // namespace finegauge
