#include "core/space/supports.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "core/mesh/region.hpp"

namespace finegauge {

namespace {

/// What is held at one node so far. The displacement there is the sum of its parts, each times its own course.
struct Held {
  struct Part {
    int motion;
    Eigen::Vector3d displacement;
  };
  Eigen::Matrix3d projector = Eigen::Matrix3d::Zero();
  Eigen::Vector3d resting = Eigen::Vector3d::Zero();
  std::vector<Part> moving;  // by motion, ascending
  int directions = 0;

  /// The part of a motion; the resting one for motion -1.
  Eigen::Vector3d& part(int motion) {
    if (motion < 0) return resting;
    if (moving.empty() || moving.back().motion != motion) moving.push_back({motion, Eigen::Vector3d::Zero()});
    return moving.back().displacement;
  }
};

/// Planes closer than this angle [rad] are one plane: their line of intersection would be round-off.
constexpr double same_plane = 1e-6;

void hold_all(Held& held, int motion, const Eigen::Vector3d& displacement) {
  const Eigen::Vector3d rest = displacement - held.projector * displacement;
  held.part(motion) += rest;
  held.projector.setIdentity();
  held.directions = 3;
}

/// Adds n·u = value. With r the part of n that is still free, u = displacement + alpha r/|r| meets it and all before.
/// That is linear in all values: each part takes its share of alpha.
void hold_component(Held& held, const Eigen::Vector3d& n, int motion, double value) {
  if (held.directions == 3) return;
  const Eigen::Vector3d r = n - held.projector * n;
  const double length = r.norm();
  if (length < same_plane) return;
  const Eigen::Vector3d direction = r / length;
  held.part(motion);  // it exists from here on
  held.resting += ((motion < 0 ? value : 0.0) - n.dot(held.resting)) / length * direction;
  for (Held::Part& part : held.moving)
    part.displacement += ((part.motion == motion ? value : 0.0) - n.dot(part.displacement)) / length * direction;
  held.projector += direction * direction.transpose();
  if (++held.directions == 3) held.projector.setIdentity();
}

/// Nodes of a surface or a region of the base mesh, ascending.
std::vector<int> supported_nodes(const BaseMesh& base, const Mesh& mesh, const std::string& name) {
  if (const auto region = base.regions.find(name); region != base.regions.end())
    return region_nodes(base, mesh, region->second);
  const auto found = base.surfaces.find(name);
  if (found == base.surfaces.end()) {
    std::string known;
    for (const auto& [other, faces] : base.surfaces) known += (known.empty() ? "" : ", ") + other;
    for (const auto& [other, nodes] : base.regions) known += (known.empty() ? "" : ", ") + other;
    throw std::invalid_argument("support on surface '" + name + "', but the mesh has " +
                                (known.empty() ? "no surfaces" : "only " + known));
  }
  std::vector<int> nodes;
  for (const BoundaryFace& face : mesh.boundary) {
    if (!std::binary_search(found->second.begin(), found->second.end(), face.base)) continue;
    for (int c = 0; c < face_corner_count(mesh.shape); ++c)
      nodes.push_back(mesh.cells[face.cell][face_corners(mesh.shape, face.face)[c]]);
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

Eigen::Vector3d prescribed(const SupportCondition& condition, const Eigen::Vector3d& X) {
  if (!condition.displacement) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d value = condition.displacement(X);
  if (!value.allFinite()) {
    std::ostringstream message;
    message << "support on surface '" << condition.surface << "': the displacement prescribed at (" << X.x() << ", "
            << X.y() << ", " << X.z() << ") is not finite";
    throw std::invalid_argument(message.str());
  }
  return value;
}

double factor(const SupportMotion& motion, double time) {
  const double value = motion.course(time);
  if (std::isfinite(value)) return value;
  std::ostringstream message;
  message << "support on surface '" << motion.surface << "': its course at the time " << time << " s is not finite";
  throw std::invalid_argument(message.str());
}

/// Per base cell the number of its body. Bodies are numbered in the order of their first cells.
std::vector<int> body_of_base_cells(const BaseTopology& topology) {
  // Union-find: a cell points to an earlier one of its body, the first one to itself.
  std::vector<int> earlier(topology.cell_faces.size());
  std::iota(earlier.begin(), earlier.end(), 0);
  const auto first_of = [&](int cell) {
    for (; earlier[cell] != cell; cell = earlier[cell]) earlier[cell] = earlier[earlier[cell]];
    return cell;
  };
  for (const auto& [one, other] : topology.face_cells) {
    if (one.cell < 0 || other.cell < 0) continue;
    const auto [low, high] = std::minmax({first_of(one.cell), first_of(other.cell)});
    earlier[high] = low;
  }
  std::vector<int> body(earlier.size());
  int bodies = 0;
  for (int cell = 0; cell < static_cast<int>(body.size()); ++cell) {
    const int first = first_of(cell);
    body[cell] = first == cell ? bodies++ : body[first];
  }
  return body;
}

/// Reduced nodes per body, ascending: corners of its leaves, and the masters of those that hang.
std::vector<std::vector<int>> nodes_of_bodies(const Mesh& mesh, const HangingNodes& hanging,
                                              const std::vector<int>& body_of_base, int bodies) {
  std::vector<std::vector<int>> nodes(bodies);
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    std::vector<int>& own = nodes[body_of_base[mesh.frames[cell].base_cell]];
    for (int c = 0; c < corner_count(mesh.shape); ++c) {
      const int node = mesh.cells[cell][c];
      own.insert(own.end(), hanging.master.begin() + hanging.row_start[node],
                 hanging.master.begin() + hanging.row_start[node + 1]);
    }
  }
  for (std::vector<int>& own : nodes) {
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
  }
  return nodes;
}

/// Rigid motions, of six, that are free when `at` (entries of `supports`) are the supports of a body.
int free_motions(const Mesh& mesh, const HangingNodes& hanging, const Supports& supports, const std::vector<int>& at) {
  if (at.empty()) return 6;
  // Centred at the supported nodes and scaled by their extent: a small patch holds a large body as well as a large one.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  const auto position = [&](int i) -> Eigen::Vector3d { return mesh.nodes.col(hanging.node_of[supports.reduced[i]]); };
  for (const int i : at) centre += position(i) / static_cast<double>(at.size());
  double extent = 0.0;
  for (const int i : at) extent = std::max(extent, (position(i) - centre).norm());
  if (extent == 0.0) extent = 1.0;

  // Gram matrix of the held part of the six motions u = t + w × x.
  Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
  for (const int i : at) {
    const Eigen::Vector3d x = (position(i) - centre) / extent;
    Eigen::Matrix<double, 3, 6> motions;
    motions << 1.0, 0.0, 0.0, 0.0, x.z(), -x.y(),  //
        0.0, 1.0, 0.0, -x.z(), 0.0, x.x(),         //
        0.0, 0.0, 1.0, x.y(), -x.x(), 0.0;
    gram += motions.transpose() * supports.held[i] * motions;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(gram, Eigen::EigenvaluesOnly);
  // Eigenvalues are squares of displacements: 1e-10 is a motion that 1e-5 of the extent holds, far above round-off.
  return static_cast<int>((solver.eigenvalues().array() < 1e-10 * solver.eigenvalues()[5]).count());
}

}  // namespace

Supports find_supports(const BaseMesh& base, const Mesh& mesh, const HangingNodes& hanging,
                       const std::vector<SupportCondition>& conditions) {
  std::vector<int> slot(hanging.reduced_count(), -1);
  std::vector<Held> held;
  Supports supports;
  for (const SupportCondition& condition : conditions) {
    const int motion = condition.course ? static_cast<int>(supports.motions.size()) : -1;
    if (condition.course) supports.motions.push_back({condition.surface, condition.course, {}, {}});
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    if (condition.normal) {
      // Scaled by the largest component first: the square of a tiny or huge normal would leave the range.
      const double largest = condition.normal->cwiseAbs().maxCoeff();
      if (!(condition.normal->allFinite() && largest > 0.0))
        throw std::invalid_argument("support on surface '" + condition.surface +
                                    "': its normal must be finite and not zero");
      normal = (*condition.normal / largest).normalized();
    }
    for (const int node : supported_nodes(base, mesh, condition.surface)) {
      // A hanging node follows its masters, which lie on the surface or in the region too.
      if (hanging.hangs(node)) continue;
      int& at = slot[hanging.reduced_of[node]];
      if (at < 0) {
        at = static_cast<int>(held.size());
        held.emplace_back();
      }
      const Eigen::Vector3d value = prescribed(condition, mesh.nodes.col(node));
      if (condition.normal)
        hold_component(held[at], normal, motion, normal.dot(value));
      else
        hold_all(held[at], motion, value);
    }
  }
  for (int reduced = 0; reduced < hanging.reduced_count(); ++reduced) {
    if (slot[reduced] < 0) continue;
    const Held& here = held[slot[reduced]];
    for (const Held::Part& part : here.moving) {
      SupportMotion& motion = supports.motions[part.motion];
      motion.at.push_back(static_cast<int>(supports.reduced.size()));
      motion.displacement.push_back(part.displacement);
    }
    supports.reduced.push_back(reduced);
    supports.held.push_back(here.projector);
    supports.displacement.push_back(here.resting);
  }
  if (!supports.motions.empty()) {
    supports.resting = supports.displacement;
    prescribe(supports, 0.0, supports.displacement);
  }
  return supports;
}

void prescribe(const Supports& supports, double time, std::vector<Eigen::Vector3d>& displacement) {
  if (supports.motions.empty()) {
    displacement = supports.displacement;
    return;
  }
  displacement = supports.resting;
  for (const SupportMotion& motion : supports.motions) {
    const double course = factor(motion, time);
    for (std::size_t i = 0; i < motion.at.size(); ++i) displacement[motion.at[i]] += course * motion.displacement[i];
  }
}

std::vector<BodyFreedom> free_rigid_motions(const BaseTopology& topology, const Mesh& mesh, const HangingNodes& hanging,
                                            const Supports& supports) {
  const std::vector<int> body_of_base = body_of_base_cells(topology);
  const int count = body_of_base.empty() ? 0 : *std::max_element(body_of_base.begin(), body_of_base.end()) + 1;
  std::vector<BodyFreedom> bodies(count, {0, Eigen::Vector3d::Zero(), 6});
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    BodyFreedom& body = bodies[body_of_base[mesh.frames[cell].base_cell]];
    if (body.cells++ > 0) continue;
    const int corners = corner_count(mesh.shape);
    for (int c = 0; c < corners; ++c) body.inside += mesh.nodes.col(mesh.cells[cell][c]) / corners;
  }
  const std::vector<std::vector<int>> nodes = nodes_of_bodies(mesh, hanging, body_of_base, count);
  for (int b = 0; b < count; ++b) {
    std::vector<int> at;
    for (int i = 0; i < static_cast<int>(supports.reduced.size()); ++i)
      if (std::binary_search(nodes[b].begin(), nodes[b].end(), supports.reduced[i])) at.push_back(i);
    bodies[b].free_motions = free_motions(mesh, hanging, supports, at);
  }
  return bodies;
}

}  // namespace finegauge
