#include "core/space/singular_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace finegauge {

namespace {

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

/// Mean angle of the cells around an edge beyond which they count as one [rad].
constexpr double widest_cell = 5.0 * std::numbers::pi / 9.0;

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

/// Per base edge, its mark where it is singular; 0 elsewhere.
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
  std::vector<std::uint8_t> marks(edges, 0);
  for (std::size_t edge = 0; edge < edges; ++edge) {
    if (faces_at[edge].empty()) continue;
    // Where more than two faces meet, bodies touch in an edge only: a hinge, singular in any case.
    if (faces_at[edge].size() == 2 && !is_singular(faces_at[edge][0], faces_at[edge][1], angle[edge], poisson_ratio))
      continue;
    const int count = topology.edge_cell_start[edge + 1] - topology.edge_cell_start[edge];
    const double exponent = faces_at[edge].size() == 2
                                ? edge_exponent(faces_at[edge][0], faces_at[edge][1], angle[edge], poisson_ratio)
                                : 0.5;
    marks[edge] = singular_edge_mark(angle[edge] > widest_cell * count ? 1 : count, exponent);
  }
  return marks;
}

/// Residual of the equation of λ of one pair of faces, none a roller.
double exponent_residual(FaceHold a, FaceHold b, double angle, double poisson_ratio, double lambda) {
  const double kappa = 3.0 - 4.0 * poisson_ratio, sine = std::sin(lambda * angle), of_angle = std::sin(angle);
  if (a == b) return (a == FaceHold::free ? 1.0 : kappa) * sine + lambda * of_angle;
  return sine * sine - ((kappa + 1.0) * (kappa + 1.0) - 4.0 * lambda * lambda * of_angle * of_angle) / (4.0 * kappa);
}

}  // namespace

std::uint8_t singular_edge_mark(int cells_around, double exponent) {
  const int level = std::clamp(static_cast<int>(64.0 * exponent), 1, 63);
  return static_cast<std::uint8_t>(64 * (std::clamp(cells_around, 1, 4) - 1) + level);
}

int cells_around_edge(std::uint8_t mark) { return 1 + mark / 64; }

double exponent_of_edge(std::uint8_t mark) { return (mark % 64 + 0.5) / 64.0; }

double edge_exponent(FaceHold a, FaceHold b, double angle, double poisson_ratio) {
  if (a > b) std::swap(a, b);
  if (a == FaceHold::roller || b == FaceHold::roller) {
    if (a == b) return 0.5;  // the mirrored body is a wedge all around the edge
    return edge_exponent(a == FaceHold::roller ? b : a, a == FaceHold::roller ? b : a, 2.0 * angle, poisson_ratio);
  }
  const auto residual = [&](double lambda) { return exponent_residual(a, b, angle, poisson_ratio, lambda); };
  constexpr double step = 1.0 / 128.0;
  for (double low = 0.25; low < 1.0; low += step) {
    double high = low + step;
    const bool rises = residual(high) > 0.0;
    if ((residual(low) > 0.0) == rises) continue;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      ((residual(middle) > 0.0) == rises ? high : low) = middle;
    }
    return std::min(high, 1.0 - 1e-9);
  }
  return 0.5;
}

std::vector<std::uint8_t> cells_at_singular_edges(const BaseMesh& base, const BaseTopology& topology, const Mesh& mesh,
                                                  const std::vector<SupportCondition>& supports, double poisson_ratio) {
  std::vector<std::uint8_t> cells(mesh.cells.size(), 0);
  if (mesh.shape != CellShape::hexahedron || base.body) return cells;
  const std::vector<std::uint8_t> marks = singular_base_edges(base, topology, supports, poisson_ratio);
  if (std::ranges::all_of(marks, [](std::uint8_t mark) { return mark == 0; })) return cells;
  const std::uint64_t unit = lattice_unit(mesh.shape);
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const LeafFrame& frame = mesh.frames[cell];
    for (int edge = 0; edge < 12; ++edge) {
      const std::uint8_t mark = marks[topology.cell_edges[frame.base_cell][edge]];
      if (mark == 0) continue;
      const int corner = hexahedron_edges[edge][0], axis = edge / 4;
      bool touches = true;
      for (const int aside : {(axis + 1) % 3, (axis + 2) % 3}) {
        const std::uint64_t low = frame.corners[0][aside], high = low + frame.corners[1][aside];
        touches = touches && ((corner >> aside) & 1 ? high == unit : low == 0);
      }
      if (touches) cells[cell] = cells[cell] == 0 ? mark : std::min(cells[cell], mark);
    }
  }
  return cells;
}

}  // namespace finegauge
