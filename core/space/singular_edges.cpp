#include "core/space/singular_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/mesh/node_identity.hpp"

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
    const auto& corners = face_corners(base_.shape, face.face);
    const auto X = [&](int c) -> Eigen::Vector3d { return base_.nodes.col(base_.cells[face.cell][corners[c]]); };
    const Eigen::Vector3d area_vector =
        base_.shape == CellShape::hexahedron ? (X(3) - X(0)).cross(X(2) - X(1)) : (X(1) - X(0)).cross(X(2) - X(0));
    return area_vector.normalized();
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
  const auto& ends = edge_corners(base.shape, edge);
  const auto X = [&](int corner) -> Eigen::Vector3d { return base.nodes.col(base.cells[cell][corner]); };
  const Eigen::Vector3d along = (X(ends[1]) - X(ends[0])).normalized();
  std::array<Eigen::Vector3d, 2> aside;
  if (base.shape == CellShape::hexahedron) {
    const int axis = edge / 4;
    for (int k = 0; k < 2; ++k) {
      const int bit = 1 << ((axis + 1 + k) % 3);
      aside[k] = 0.5 * (X(ends[0] ^ bit) - X(ends[0]) + X(ends[1] ^ bit) - X(ends[1]));
    }
  } else {
    int k = 0;
    for (int corner = 0; corner < 4; ++corner)
      if (corner != ends[0] && corner != ends[1]) aside[k++] = X(corner) - X(ends[0]);
  }
  for (Eigen::Vector3d& side : aside) side -= along.dot(side) * along;
  return std::atan2(aside[0].cross(aside[1]).norm(), aside[0].dot(aside[1]));
}

/// A face of the boundary.
struct OuterFace {
  int face;
  FaceHold hold;
};

/// What meets at each base edge.
struct EdgeSurroundings {
  std::vector<std::vector<OuterFace>> faces;  ///< none inside of the body
  std::vector<double> angle;                  ///< of the material [rad], where there are faces
};

EdgeSurroundings edge_surroundings(const BaseMesh& base, const BaseTopology& topology,
                                   const std::vector<SupportCondition>& supports) {
  const Holds holds(base, supports);
  const std::size_t edges = topology.edges.size();
  EdgeSurroundings around{std::vector<std::vector<OuterFace>>(edges), std::vector<double>(edges, 0.0)};
  for (const auto& [first, second] : topology.face_cells) {
    if (second.cell >= 0) continue;
    const auto& corners = face_corners(base.shape, first.face);
    const FaceHold hold = holds.of(first);
    for (int edge = 0; edge < edge_count(base.shape); ++edge) {
      const auto& ends = edge_corners(base.shape, edge);
      if (std::ranges::find(corners, ends[0]) != corners.end() && std::ranges::find(corners, ends[1]) != corners.end())
        around.faces[topology.cell_edges[first.cell][edge]].push_back(
            {topology.cell_faces[first.cell][first.face].face, hold});
    }
  }
  for (int cell = 0; cell < static_cast<int>(base.cells.size()); ++cell)
    for (int edge = 0; edge < edge_count(base.shape); ++edge)
      if (const int number = topology.cell_edges[cell][edge]; !around.faces[number].empty())
        around.angle[number] += angle_at(base, cell, edge);
  return around;
}

SingularEdge singular_edge(CellShape shape, int count, double angle, double exponent) {
  const int cells = shape == CellShape::tetrahedron ? (count + 1) / 2 : angle > widest_cell * count ? 1 : count;
  return {static_cast<std::uint8_t>(std::clamp(cells, 1, 4)),
          static_cast<std::uint8_t>(std::clamp(static_cast<int>(64.0 * exponent), 1, 63))};
}

/// Per base edge; none where it is not singular.
std::vector<SingularEdge> singular_base_edges(const BaseMesh& base, const BaseTopology& topology,
                                              const EdgeSurroundings& around, double poisson_ratio) {
  std::vector<SingularEdge> singular(topology.edges.size());
  for (std::size_t edge = 0; edge < singular.size(); ++edge) {
    const std::vector<OuterFace>& faces = around.faces[edge];
    if (faces.empty()) continue;
    // Where more than two faces meet, bodies touch in an edge only: a hinge, singular in any case.
    const bool hinge = faces.size() != 2;
    if (!hinge && !is_singular(faces[0].hold, faces[1].hold, around.angle[edge], poisson_ratio)) continue;
    const int count = topology.edge_cell_start[edge + 1] - topology.edge_cell_start[edge];
    const double exponent =
        hinge ? 0.5 : edge_exponent(faces[0].hold, faces[1].hold, around.angle[edge], poisson_ratio);
    singular[edge] = singular_edge(base.shape, count, around.angle[edge], exponent);
  }
  return singular;
}

void keep_first(SingularEdge& kept, const SingularEdge& other) {
  if (other && (!kept || counts_before(other, kept))) kept = other;
}

/// Whether an edge of a hexahedral leaf lies on that edge of its base cell.
bool has_edge_on(const LeafFrame& frame, int edge) {
  constexpr std::uint64_t unit = lattice_unit(CellShape::hexahedron);
  const int corner = hexahedron_edges[edge][0], axis = edge / 4;
  for (const int aside : {(axis + 1) % 3, (axis + 2) % 3}) {
    const std::uint64_t low = frame.corners[0][aside], high = low + frame.corners[1][aside];
    if ((corner >> aside) & 1 ? high != unit : low != 0) return false;
  }
  return true;
}

std::vector<SingularEdge> of_hexahedra(const BaseTopology& topology, const Mesh& mesh,
                                       const std::vector<SingularEdge>& of_edges) {
  std::vector<SingularEdge> cells(mesh.cells.size());
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int edge = 0; edge < 12; ++edge)
      if (const SingularEdge& found = of_edges[topology.cell_edges[mesh.frames[cell].base_cell][edge]];
          found && has_edge_on(mesh.frames[cell], edge))
        keep_first(cells[cell], found);
  return cells;
}

/// Base entities by their dimension and number.
using EntityMarks = std::array<std::vector<std::uint8_t>, 3>;

/// The faces that meet at singular edges with all their edges and vertices. Rollers do not count: their mirror puts
/// what touches them in the middle of the body.
EntityMarks faces_at_edges(const BaseMesh& base, const BaseTopology& topology, const EdgeSurroundings& around,
                           const std::vector<SingularEdge>& of_edges) {
  EntityMarks marks;
  marks[0].assign(static_cast<std::size_t>(base.nodes.cols()), 0);
  marks[1].assign(topology.edges.size(), 0);
  marks[2].assign(topology.faces.size(), 0);
  for (std::size_t edge = 0; edge < of_edges.size(); ++edge)
    if (of_edges[edge])
      for (const OuterFace& outer : around.faces[edge])
        if (outer.hold != FaceHold::roller) marks[2][outer.face] = 1;
  for (std::size_t face = 0; face < topology.faces.size(); ++face) {
    if (!marks[2][face]) continue;
    const auto& [cell, local] = topology.face_cells[face][0];
    const auto& corners = face_corners(base.shape, local);
    for (int k = 0; k < face_corner_count(base.shape); ++k) marks[0][base.cells[cell][corners[k]]] = 1;
    for (int edge = 0; edge < edge_count(base.shape); ++edge) {
      const auto& ends = edge_corners(base.shape, edge);
      if (std::ranges::find(corners, ends[0]) != corners.end() && std::ranges::find(corners, ends[1]) != corners.end())
        marks[1][topology.cell_edges[cell][edge]] = 1;
    }
  }
  return marks;
}

/// Per base vertex, of the edges that end there the one that counts.
std::vector<SingularEdge> singular_vertices(const BaseMesh& base, const BaseTopology& topology,
                                            const std::vector<SingularEdge>& of_edges) {
  std::vector<SingularEdge> of_vertices(static_cast<std::size_t>(base.nodes.cols()));
  for (std::size_t edge = 0; edge < of_edges.size(); ++edge)
    for (const int end : topology.edges[edge]) keep_first(of_vertices[end], of_edges[edge]);
  return of_vertices;
}

/// Of a node, by what it lies on.
SingularEdge edge_at(const NodeIdentity& identity, const std::vector<SingularEdge>& of_vertices,
                     const std::vector<SingularEdge>& of_edges) {
  const int dimension = entity_dimension(identity), index = entity_index(identity);
  return dimension == 0 ? of_vertices[index] : dimension == 1 ? of_edges[index] : SingularEdge{};
}

/// Whether two corners of a leaf lie on the same singular edge, which then is one of its base cell.
bool lies_along_one(const BaseTopology& topology, const Mesh& mesh, int cell,
                    const std::vector<SingularEdge>& of_edges) {
  for (int e = 0; e < edge_count(CellShape::tetrahedron); ++e) {
    const int edge = topology.cell_edges[mesh.frames[cell].base_cell][e];
    if (!of_edges[edge]) continue;
    int there = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const NodeIdentity& identity = mesh.identities[mesh.cells[cell][corner]];
      const int dimension = entity_dimension(identity), index = entity_index(identity);
      const auto& ends = topology.edges[edge];
      there += (dimension == 1 && index == edge) || (dimension == 0 && (index == ends[0] || index == ends[1]));
    }
    if (there > 1) return true;
  }
  return false;
}

std::vector<SingularEdge> of_tetrahedra(const BaseMesh& base, const BaseTopology& topology, const Mesh& mesh,
                                        const EdgeSurroundings& around, const std::vector<SingularEdge>& of_edges) {
  const std::vector<SingularEdge> of_vertices = singular_vertices(base, topology, of_edges);
  const EntityMarks on_faces = faces_at_edges(base, topology, around, of_edges);
  std::vector<SingularEdge> cells(mesh.cells.size());
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    int beside = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const NodeIdentity& identity = mesh.identities[mesh.cells[cell][corner]];
      const int dimension = entity_dimension(identity);
      if (const SingularEdge found = edge_at(identity, of_vertices, of_edges))
        keep_first(cells[cell], found);
      else if (dimension < 3 && on_faces[static_cast<std::size_t>(dimension)][entity_index(identity)])
        ++beside;
    }
    if (!cells[cell]) continue;
    cells[cell].lies_along = lies_along_one(topology, mesh, cell, of_edges);
    cells[cell].within = beside == 0;
  }
  return cells;
}

/// Residual of the equation of λ of one pair of faces, none a roller.
double exponent_residual(FaceHold a, FaceHold b, double angle, double poisson_ratio, double lambda) {
  const double kappa = 3.0 - 4.0 * poisson_ratio, sine = std::sin(lambda * angle), of_angle = std::sin(angle);
  if (a == b) return (a == FaceHold::free ? 1.0 : kappa) * sine + lambda * of_angle;
  return sine * sine - ((kappa + 1.0) * (kappa + 1.0) - 4.0 * lambda * lambda * of_angle * of_angle) / (4.0 * kappa);
}

}  // namespace

bool counts_before(const SingularEdge& a, const SingularEdge& b) {
  if (a.cells != b.cells) return a.cells < b.cells;
  return a.exponent_64ths < b.exponent_64ths;
}

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

std::vector<SingularEdge> singular_edges_of_cells(const BaseMesh& base, const BaseTopology& topology, const Mesh& mesh,
                                                  const std::vector<SupportCondition>& supports, double poisson_ratio) {
  if (!base.body) {
    const EdgeSurroundings around = edge_surroundings(base, topology, supports);
    const std::vector<SingularEdge> of_edges = singular_base_edges(base, topology, around, poisson_ratio);
    if (std::ranges::any_of(of_edges, [](const SingularEdge& edge) { return static_cast<bool>(edge); }))
      return mesh.shape == CellShape::hexahedron ? of_hexahedra(topology, mesh, of_edges)
                                                 : of_tetrahedra(base, topology, mesh, around, of_edges);
  }
  return std::vector<SingularEdge>(mesh.cells.size());
}

std::vector<std::uint8_t> nodes_on_singular_edges(const BaseMesh& base, const BaseTopology& topology, const Mesh& mesh,
                                                  const std::vector<SupportCondition>& supports, double poisson_ratio) {
  std::vector<std::uint8_t> nodes(mesh.identities.size());
  if (base.body) return nodes;
  const std::vector<SingularEdge> of_edges =
      singular_base_edges(base, topology, edge_surroundings(base, topology, supports), poisson_ratio);
  const std::vector<SingularEdge> of_vertices = singular_vertices(base, topology, of_edges);
  for (std::size_t node = 0; node < nodes.size(); ++node)
    nodes[node] = static_cast<bool>(edge_at(mesh.identities[node], of_vertices, of_edges));
  return nodes;
}

}  // namespace finegauge
