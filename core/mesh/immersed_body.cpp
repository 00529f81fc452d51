#include "core/mesh/immersed_body.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "core/mesh/material_share.hpp"
#include "core/mesh/position_text.hpp"

namespace finegauge {
namespace {

void check_surface(const TriangleSurface& surface) {
  if (surface.triangles.empty()) throw std::invalid_argument("surface: it has no triangles");
  for (int triangle = 0; triangle < surface.triangle_count(); ++triangle)
    for (const int vertex : surface.triangles[triangle]) {
      const std::string subject = "surface: triangle " + std::to_string(triangle);
      if (vertex < 0 || vertex >= surface.vertices.cols())
        throw std::invalid_argument(subject + " has vertex " + std::to_string(vertex) +
                                    ", but there are vertices 0 to " + std::to_string(surface.vertices.cols() - 1));
      if (!surface.vertices.col(vertex).allFinite())
        throw std::invalid_argument(subject + " has a corner at " + describe(surface.vertices.col(vertex)) +
                                    ": coordinates must be finite [m]");
    }
  if (const auto edge = open_edge(surface))
    throw std::invalid_argument("surface: it is not closed at the edge from " + describe(edge->from) + " to " +
                                describe(edge->to) + ": each edge needs a triangle on both sides, turned alike");
  if (const double volume = enclosed_volume(surface); !(volume > 0.0)) {
    std::ostringstream message;
    message << "surface: the enclosed volume is " << volume
            << " m³, but must be positive: corners of triangles go counter-clockwise seen from outside";
    throw std::invalid_argument(message.str());
  }
}

/// By how much of a cell the surface may stick out of its lattice: a layer of that thickness weighs nothing.
constexpr double lattice_round_off = 1e-6;

/// Lower corner and number of cells; throws where the lattice would be empty or miss the surface. A layer no thicker
/// than least_base_share is not worth a lattice cell.
void place_lattice(const BoundingBox& around, const ImmersedMeshOptions& options, ImmersedBody& body) {
  double count = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double h = options.cell_size[axis];
    std::ostringstream message;
    message.precision(17);
    if (!(h > 0.0 && std::isfinite(h)))
      message << "cell size along " << axis_names[axis] << " is " << h << ", but must be positive and finite [m]";
    else if (options.origin && !std::isfinite((*options.origin)[axis]))
      message << "origin along " << axis_names[axis] << " is " << (*options.origin)[axis] << ", but must be finite [m]";
    if (!message.str().empty()) throw std::invalid_argument(message.str());

    const double lower = around.lower[axis], upper = around.upper[axis];
    const double start = options.origin ? (*options.origin)[axis] : 0.5 * lower + 0.5 * upper;
    double first, last;  // planes of the lattice, cells from start
    if (options.origin) {
      first = std::floor((lower - start) / h + least_base_share);
      last = std::max(first + 1.0, std::ceil((upper - start) / h - least_base_share));
    } else {
      const double cells = std::max(1.0, std::ceil((upper - lower) / h - 2.0 * least_base_share));
      first = -0.5 * cells;
      last = 0.5 * cells;
    }
    count *= last - first;
    if (!(count <= most_lattice_cells)) {
      message << "cell size: the surface spans " << upper - lower << " m along " << axis_names[axis]
              << " and the lattice would have more than " << most_lattice_cells << " cells of " << h << " m along it";
      throw std::invalid_argument(message.str());
    }
    body.origin[axis] = start + first * h;
    // A cell is lost in the round-off of its planes' distance from a far origin.
    const double below = (lower - body.origin[axis]) / h, above = (upper - body.origin[axis]) / h;
    if (!(last - first >= 1.0 && below >= -lattice_round_off && above <= last - first + lattice_round_off)) {
      message << "origin along " << axis_names[axis] << " is " << start << " m, " << std::abs(lower - start) / h
              << " cells of " << h
              << " m from the surface, but so far off rounding leaves no lattice around it; at most "
              << "some 1e9 cells";
      throw std::invalid_argument(message.str());
    }
    body.cell_size[axis] = h;
    body.lattice_cells[axis] = static_cast<int>(last - first);
  }
}

/// Base cells in order: those with more material than least_base_share.
void find_cells(ImmersedBody& body) {
  const auto& n = body.lattice_cells;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        const double share = integrated_share(body, {Eigen::Vector3d(i, j, k), Eigen::Vector3d(i + 1, j + 1, k + 1)});
        if (!(share > -least_base_share && share < 1.0 + least_base_share)) {
          std::ostringstream message;
          message << "surface: the lattice cell at " << describe(lattice_position(body, {i, j, k})) << " holds "
                  << share << " times its volume: the surface must not cut or enclose itself";
          throw std::invalid_argument(message.str());
        }
        if (!(share > least_base_share)) continue;
        body.place.push_back({i, j, k});
        body.share.push_back(rounded_share(share));
      }
  if (body.place.empty())
    throw std::invalid_argument("surface: no lattice cell holds a share of material above 1e-9; are cells too large?");
}

}  // namespace

Eigen::Vector3d lattice_position(const ImmersedBody& body, const std::array<int, 3>& at) {
  return body.origin + body.cell_size.cwiseProduct(Eigen::Vector3d(at[0], at[1], at[2]));
}

void index_surface(ImmersedBody& body) {
  const TriangleSurface& surface = body.surface;
  body.lattice_vertices =
      ((surface.vertices.colwise() - body.origin).array().colwise() / body.cell_size.array()).matrix();
  const int triangles = surface.triangle_count();
  body.triangle_boxes.resize(triangles);
  const auto& n = body.lattice_cells;
  const auto column_of = [&](double x, int axis) {
    return static_cast<int>(std::clamp(std::floor(x), 0.0, static_cast<double>(n[axis] - 1)));
  };
  // Twice over the triangles: count, then fill.
  body.column_start.assign(n[0] * n[1] + 1, 0);
  std::vector<int> next;
  std::int64_t entries = 0;
  for (const bool fill : {false, true}) {
    for (int triangle = 0; triangle < triangles; ++triangle) {
      BoundingBox& around = body.triangle_boxes[triangle];
      const auto& [a, b, c] = surface.triangles[triangle];
      const auto& v = body.lattice_vertices;
      around = {v.col(a).cwiseMin(v.col(b)).cwiseMin(v.col(c)), v.col(a).cwiseMax(v.col(b)).cwiseMax(v.col(c))};
      for (int j = column_of(around.lower.y(), 1); j <= column_of(around.upper.y(), 1); ++j)
        for (int i = column_of(around.lower.x(), 0); i <= column_of(around.upper.x(), 0); ++i) {
          if (fill) {
            body.column_triangles[next[i + n[0] * j]++] = triangle;
          } else {
            ++body.column_start[i + n[0] * j + 1];
            ++entries;
          }
        }
    }
    if (fill) break;
    if (entries > std::numeric_limits<int>::max())
      throw std::invalid_argument("surface: triangles and columns of cells meet " + std::to_string(entries) +
                                  " times; so many large triangles go with larger cells only");
    std::partial_sum(body.column_start.begin(), body.column_start.end(), body.column_start.begin());
    body.column_triangles.resize(body.column_start.back());
    next.assign(body.column_start.begin(), body.column_start.end() - 1);
  }
}

void index_cells(ImmersedBody& body) {
  const auto& n = body.lattice_cells;
  const auto number = [&](int i, int j, int k) {
    return i + static_cast<std::size_t>(n[0]) * (j + static_cast<std::size_t>(n[1]) * k);
  };
  std::vector<int> cell_at(number(0, 0, n[2]), -1);
  const int cells = static_cast<int>(body.place.size());
  for (int cell = 0; cell < cells; ++cell) {
    const auto& [i, j, k] = body.place[cell];
    cell_at[number(i, j, k)] = cell;
  }
  const auto visit_cells = [&](int triangle, const auto& visit) {
    const Eigen::Vector3d lower = body.triangle_boxes[triangle].lower.array() - surface_slack;
    const Eigen::Vector3d upper = body.triangle_boxes[triangle].upper.array() + surface_slack;
    std::array<int, 3> first, last;
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = static_cast<int>(std::max(std::floor(lower[axis]), 0.0));
      last[axis] = static_cast<int>(std::min(std::floor(upper[axis]), n[axis] - 1.0));
    }
    const auto& [a, b, c] = body.surface.triangles[triangle];
    const auto& v = body.lattice_vertices;
    const Eigen::Vector3d normal = (v.col(b) - v.col(a)).cross(v.col(c) - v.col(a));
    const double reach = (0.5 + surface_slack) * normal.cwiseAbs().sum();
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i) {
          const int cell = cell_at[number(i, j, k)];
          if (cell < 0) continue;
          // The triangle's plane misses the cell where the cell's middle is farther from it than any corner.
          if (std::abs(normal.dot(Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5) - v.col(a))) <= reach) visit(cell);
        }
  };
  body.cell_start.assign(cells + 1, 0);
  const int triangles = body.surface.triangle_count();
  for (int triangle = 0; triangle < triangles; ++triangle)
    visit_cells(triangle, [&](int cell) { ++body.cell_start[cell + 1]; });
  std::partial_sum(body.cell_start.begin(), body.cell_start.end(), body.cell_start.begin());
  body.cell_triangles.resize(body.cell_start.back());
  std::vector<int> next(body.cell_start.begin(), body.cell_start.end() - 1);
  for (int triangle = 0; triangle < triangles; ++triangle)
    visit_cells(triangle, [&](int cell) { body.cell_triangles[next[cell]++] = triangle; });
}

BaseMesh immersed_mesh(TriangleSurface surface, const ImmersedMeshOptions& options) {
  check_surface(surface);
  auto body = std::make_shared<ImmersedBody>();
  place_lattice(bounding_box(surface), options, *body);
  body->surface = std::move(surface);
  index_surface(*body);
  find_cells(*body);
  index_cells(*body);

  // Lattice nodes that no cell uses do not become nodes.
  const auto& n = body->lattice_cells;
  std::vector<int> node_of(static_cast<std::size_t>(n[0] + 1) * (n[1] + 1) * (n[2] + 1), -1);
  const auto lattice_node = [&](const std::array<int, 3>& place, int corner) -> int& {
    const std::size_t i = place[0] + (corner & 1), j = place[1] + ((corner >> 1) & 1), k = place[2] + (corner >> 2);
    return node_of[i + (n[0] + 1) * (j + (n[1] + 1) * k)];
  };
  for (const auto& place : body->place)
    for (int c = 0; c < 8; ++c) lattice_node(place, c) = 0;
  BaseMesh mesh;
  mesh.nodes.resize(3, std::count(node_of.begin(), node_of.end(), 0));
  int next = 0;
  std::size_t lattice = 0;
  for (int k = 0; k <= n[2]; ++k)
    for (int j = 0; j <= n[1]; ++j)
      for (int i = 0; i <= n[0]; ++i) {
        int& node = node_of[lattice++];
        if (node < 0) continue;
        node = next++;
        mesh.nodes.col(node) = lattice_position(*body, {i, j, k});
      }
  for (const auto& place : body->place) {
    std::array<int, max_corners> corners;
    for (int c = 0; c < 8; ++c) corners[c] = lattice_node(place, c);
    mesh.cells.push_back(corners);
  }
  mesh.body = std::move(body);
  return mesh;
}

bool contains(const ImmersedBody& body, const Eigen::Vector3d& X) {
  const Eigen::Vector3d p = (X - body.origin).cwiseQuotient(body.cell_size);
  std::array<int, 2> place;
  for (int axis = 0; axis < 2; ++axis) {
    const int last = body.lattice_cells[axis] - 1;
    if (!(p[axis] > -1.0 && p[axis] < last + 2.0)) return false;
    place[axis] = std::clamp(static_cast<int>(std::floor(p[axis])), 0, last);
  }
  const int column = place[0] + body.lattice_cells[0] * place[1];
  int windings = 0;
  for (int k = body.column_start[column]; k < body.column_start[column + 1]; ++k) {
    const int triangle = body.column_triangles[k];
    const BoundingBox& around = body.triangle_boxes[triangle];
    if (around.lower.y() > p.y() || around.upper.y() <= p.y() || around.lower.x() > p.x() ||
        around.upper.x() <= p.x() || around.upper.z() <= p.z())
      continue;
    // The triangle's section with the plane y = p.y: from the edge that goes down through it to the one that goes up.
    std::array<double, 2> x{}, z{};
    const auto& corners = body.surface.triangles[triangle];
    for (int c = 0; c < 3; ++c) {
      const auto from = body.lattice_vertices.col(corners[c]), to = body.lattice_vertices.col(corners[(c + 1) % 3]);
      if ((from.y() <= p.y()) == (to.y() <= p.y())) continue;
      const bool up = from.y() <= p.y();
      const Eigen::Vector3d low = up ? from : to, high = up ? to : from;
      const double s = (p.y() - low.y()) / (high.y() - low.y());
      x[up] = std::clamp(low.x() + s * (high.x() - low.x()), std::min(low.x(), high.x()), std::max(low.x(), high.x()));
      z[up] = low.z() + s * (high.z() - low.z());
    }
    const int crossing = (x[1] > p.x() ? 1 : 0) - (x[0] > p.x() ? 1 : 0);
    if (crossing == 0) continue;
    const double height = z[0] + (p.x() - x[0]) / (x[1] - x[0]) * (z[1] - z[0]);
    if (height > p.z()) windings += crossing;
  }
  return windings > 0;
}

std::string validate(const ImmersedBody& body, const BaseMesh& mesh) {
  if (mesh.shape != CellShape::hexahedron) return "an immersed body needs hexahedra";
  if (body.place.size() != mesh.cells.size() || body.share.size() != mesh.cells.size())
    return "the immersed body knows " + std::to_string(body.place.size()) + " places and " +
           std::to_string(body.share.size()) + " shares of " + std::to_string(mesh.cells.size()) + " base cells";
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
    const std::string subject = "cell " + std::to_string(cell);
    for (int axis = 0; axis < 3; ++axis)
      if (body.place[cell][axis] < 0 || body.place[cell][axis] >= body.lattice_cells[axis])
        return subject + " lies outside the immersed body's lattice";
    for (int c = 0; c < 8; ++c) {
      const auto& [i, j, k] = body.place[cell];
      if (mesh.nodes.col(mesh.cells[cell][c]) !=
          lattice_position(body, {i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2)}))
        return subject + " is not the lattice cell of the immersed body at its place: corner " + std::to_string(c) +
               " lies elsewhere";
    }
    if (!(body.share[cell] > 0.0 && body.share[cell] <= 1.0))
      return subject + " has a share of " + std::to_string(body.share[cell]) + " of material";
  }
  return {};
}

}  // namespace finegauge
