#include "core/space/singular_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace finegauge {

namespace {

enum class FaceHold { free, roller, clamped };

/// Directions that conditions hold on each boundary face of the base mesh.
class Holds {
 public:
  Holds(const BaseMesh& base, const std::vector<SupportCondition>& supports) : base_(base) {
    for (const SupportCondition& condition : supports) {
      const auto surface = base.surfaces.find(condition.surface);
      if (surface == base.surfaces.end()) continue;
      for (const BaseFace& face : surface->second)
        directions_[face].push_back(condition.normal ? condition.normal->normalized()
                                                     : Eigen::Vector3d(Eigen::Vector3d::Zero()));
    }
  }
  FaceHold of(const BaseFace& face) const {
    const auto found = directions_.find(face);
    if (found == directions_.end()) return FaceHold::free;
    Eigen::Matrix3d held = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& direction : found->second) {
      if (direction.isZero()) return FaceHold::clamped;
      held += direction * direction.transpose();
    }
    if (held.determinant() > 1e-9) return FaceHold::clamped;
    const Eigen::Vector3d n = normal(face);
    return n.dot(held * n) > 0.5 ? FaceHold::roller : FaceHold::free;
  }

 private:
  Eigen::Vector3d normal(const BaseFace& face) const {
    const auto& corners = hexahedron_faces[face.face];
    const auto X = [&](int c) -> Eigen::Vector3d { return base_.nodes.col(base_.cells[face.cell][corners[c]]); };
    return (X(3) - X(0)).cross(X(2) - X(1)).normalized();
  }
  const BaseMesh& base_;
  std::map<BaseFace, std::vector<Eigen::Vector3d>> directions_;
};

bool is_singular(FaceHold a, FaceHold b, double angle, double poisson_ratio) {
  constexpr double pi = std::numbers::pi, bend = pi / 12.0;
  if (a > b) std::swap(a, b);
  if (a == FaceHold::roller && b == FaceHold::roller) return angle > pi / 2.0 + bend && std::abs(angle - pi) > bend;
  if (a == b) return angle > pi + bend;
  if (a == FaceHold::free && b == FaceHold::clamped)
    // The clamped corner's equation at λ = 1: sin² ω = ((κ + 1)² - 4 sin² ω) / 4κ, κ = 3 - 4 nu.
    return angle > std::min(pi / 2.0 - bend, std::asin(std::sqrt(std::clamp(1.0 - poisson_ratio, 0.0, 1.0)))) + bend;
  return angle > pi / 2.0 + bend;
}

/// Angle of the cell's material at one of its edges, in the middle of it [rad].
double angle_at(const BaseMesh& base, int cell, int edge) {
  const auto& corners = edge_corners(CellShape::hexahedron, edge);
  const int axis = edge / 4;
  const auto X = [&](int corner) -> Eigen::Vector3d { return base.nodes.col(base.cells[cell][corner]); };
  const Eigen::Vector3d along = (X(corners[1]) - X(corners[0])).normalized();
  std::array<Eigen::Vector3d, 2> aside;
  for (int k = 0; k < 2; ++k) {
    const int bit = 1 << ((axis + 1 + k) % 3);
    aside[k] = 0.5 * (X(corners[0] ^ bit) - X(corners[0]) + X(corners[1] ^ bit) - X(corners[1]));
    aside[k] -= along.dot(aside[k]) * along;
  }
  return std::atan2(aside[0].cross(aside[1]).norm(), aside[0].dot(aside[1]));
}

/// Per base edge, the number of cells around it where it is singular; 0 elsewhere.
std::vector<std::uint8_t> singular_base_edges(const BaseMesh& base, const BaseTopology& topology,
                                              const std::vector<SupportCondition>& supports, double poisson_ratio) {
  const Holds holds(base, supports);
  const std::size_t edges = topology.edges.size();
  std::vector<std::vector<FaceHold>> faces_at(edges);
  for (const auto& [first, second] : topology.face_cells) {
    if (second.cell >= 0) continue;
    const auto& corners = hexahedron_faces[first.face];
    const FaceHold hold = holds.of(first);
    for (int edge = 0; edge < 12; ++edge) {
      const auto& ends = hexahedron_edges[edge];
      if (std::ranges::find(corners, ends[0]) != corners.end() && std::ranges::find(corners, ends[1]) != corners.end())
        faces_at[topology.cell_edges[first.cell][edge]].push_back(hold);
    }
  }
  std::vector<double> angle(edges, 0.0);
  for (int cell = 0; cell < static_cast<int>(base.cells.size()); ++cell)
    for (int edge = 0; edge < 12; ++edge)
      if (const int number = topology.cell_edges[cell][edge]; !faces_at[number].empty())
        angle[number] += angle_at(base, cell, edge);
  std::vector<std::uint8_t> around(edges, 0);
  for (std::size_t edge = 0; edge < edges; ++edge) {
    if (faces_at[edge].empty()) continue;
    // Where more than two faces meet, bodies touch in an edge only: a hinge, singular in any case.
    if (faces_at[edge].size() == 2 && !is_singular(faces_at[edge][0], faces_at[edge][1], angle[edge], poisson_ratio))
      continue;
    around[edge] =
        static_cast<std::uint8_t>(std::min(255, topology.edge_cell_start[edge + 1] - topology.edge_cell_start[edge]));
  }
  return around;
}

}  // namespace

std::vector<std::uint8_t> cells_at_singular_edges(const BaseMesh& base, const BaseTopology& topology, const Mesh& mesh,
                                                  const std::vector<SupportCondition>& supports, double poisson_ratio) {
  std::vector<std::uint8_t> cells(mesh.cells.size(), 0);
  if (mesh.shape != CellShape::hexahedron || base.body) return cells;
  const std::vector<std::uint8_t> around = singular_base_edges(base, topology, supports, poisson_ratio);
  if (std::ranges::all_of(around, [](std::uint8_t count) { return count == 0; })) return cells;
  const std::uint64_t unit = lattice_unit(mesh.shape);
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const LeafFrame& frame = mesh.frames[cell];
    for (int edge = 0; edge < 12; ++edge) {
      const std::uint8_t count = around[topology.cell_edges[frame.base_cell][edge]];
      if (count == 0) continue;
      const int corner = hexahedron_edges[edge][0], axis = edge / 4;
      bool touches = true;
      for (const int aside : {(axis + 1) % 3, (axis + 2) % 3}) {
        const std::uint64_t low = frame.corners[0][aside], high = low + frame.corners[1][aside];
        touches = touches && ((corner >> aside) & 1 ? high == unit : low == 0);
      }
      if (touches) cells[cell] = cells[cell] == 0 ? count : std::min(cells[cell], count);
    }
  }
  return cells;
}

}  // namespace finegauge
