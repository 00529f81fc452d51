#include "core/space/springs.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace finegauge {
namespace {

[[noreturn]] void refuse(const SpringSupport& support, const std::string& what) {
  throw std::invalid_argument("springs '" + support.name + "': " + what);
}

template <class Value>
std::string text(const Value& value) {
  std::ostringstream stream;
  stream << value;
  return stream.str();
}

void check_point(const BaseMesh& base, const SpringSupport& support, const SpringPoint& point) {
  const int cells = static_cast<int>(base.cells.size());
  if (!(point.at.base_cell >= 0 && point.at.base_cell < cells))
    refuse(support, "a point in base cell " + text(point.at.base_cell) + ", allowed is 0 to " + text(cells - 1));
  const Eigen::Vector3d& xi = point.at.xi;
  const double beyond = base.shape == CellShape::hexahedron ? xi.maxCoeff() : xi.sum();
  if (!(xi.allFinite() && xi.minCoeff() >= -location_slack && beyond <= 1.0 + location_slack))
    refuse(support, "a point at the natural coordinates (" + text(xi.transpose()) + "), which is outside of its cell");
  if (!(point.stiffness > 0.0 && std::isfinite(point.stiffness)))
    refuse(support, "stiffness " + text(point.stiffness) + " N/m, allowed is finite and > 0");
}

/// Natural coordinates in a leaf of a point of its base cell.
Eigen::Vector3d coordinates_in_leaf(CellShape shape, const LeafFrame& leaf, const Eigen::Vector3d& base_xi) {
  const double unit = static_cast<double>(lattice_unit(shape));
  const auto corner = [&](int c) -> Eigen::Vector3d {
    const LatticePoint& at = leaf.corners[c];
    return Eigen::Vector3d(static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2])) / unit;
  };
  const Eigen::Vector3d from_corner = base_xi - corner(0);
  if (shape == CellShape::hexahedron) return from_corner.cwiseQuotient(corner(1));
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = corner(k + 1) - corner(0);
  return edges.inverse() * from_corner;
}

/// The leaf that contains the point, the first of those that share it. Of the leaves of its base cell the one that it
/// is least outside of, which asks for no slack.
void locate(const Mesh& mesh, Springs::Point& point) {
  const auto before = [](const LeafFrame& frame, int base_cell) { return frame.base_cell < base_cell; };
  const auto first = std::lower_bound(mesh.frames.begin(), mesh.frames.end(), point.at.base_cell, before);
  double least = std::numeric_limits<double>::infinity();
  point.cell = -1;
  for (auto leaf = first; leaf != mesh.frames.end() && leaf->base_cell == point.at.base_cell && least > 0.0; ++leaf) {
    const Eigen::Vector3d xi = coordinates_in_leaf(mesh.shape, *leaf, point.at.xi);
    const double beyond = mesh.shape == CellShape::hexahedron ? xi.maxCoeff() : xi.sum();
    const double outside = std::max({0.0, -xi.minCoeff(), beyond - 1.0});
    if (!(outside < least)) continue;
    least = outside;
    point.xi = xi;
    point.cell = static_cast<int>(leaf - mesh.frames.begin());
  }
  point.N = shape_functions(mesh.shape, point.xi);
}

void build_matrices(const Mesh& mesh, Springs& springs) {
  springs.matrices.clear();
  springs.matrix_number.clear();
  if (springs.empty()) return;
  springs.matrix_number.assign(mesh.cells.size(), -1);
  for (const Springs::Point& point : springs.points) {
    int& number = springs.matrix_number[point.cell];
    if (number < 0) {
      number = static_cast<int>(springs.matrices.size());
      springs.matrices.push_back(SpringMatrix::Zero());
    }
    const Eigen::Map<const Eigen::Matrix<double, max_corners, 1>> N(point.N.data());
    springs.matrices[number] += point.stiffness * N * N.transpose();
  }
}

Eigen::Vector3d value_at(const Mesh& mesh, const Springs::Point& point, const Eigen::Matrix3Xd& nodal) {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (int c = 0; c < corner_count(mesh.shape); ++c) value += point.N[c] * nodal.col(mesh.cells[point.cell][c]);
  return value;
}

void spread(const Mesh& mesh, const Springs::Point& point, const Eigen::Vector3d& force, Eigen::Matrix3Xd& forces) {
  for (int c = 0; c < corner_count(mesh.shape); ++c) forces.col(mesh.cells[point.cell][c]) += point.N[c] * force;
}

double course_at(const Springs::Support& support, double time) {
  if (!support.course) return 1.0;
  if (std::isnan(time)) throw std::invalid_argument("springs '" + support.name + "' move, and no time is given");
  const double value = support.course(time);
  if (!std::isfinite(value))
    throw std::invalid_argument("springs '" + support.name + "': their course at the time " + text(time) +
                                " s is not finite");
  return value;
}

}  // namespace

Springs find_springs(const BaseMesh& base, const Mesh& mesh, const std::vector<SpringSupport>& supports) {
  Springs springs;
  for (const SpringSupport& support : supports) {
    for (const SpringPoint& spring : support.points) {
      check_point(base, support, spring);
      Springs::Point point{};
      point.support = static_cast<int>(springs.supports.size());
      point.at = spring.at;
      point.stiffness = spring.stiffness;
      point.X = rest_position(base, spring.at);
      point.displacement = support.displacement ? support.displacement(point.X) : Eigen::Vector3d::Zero();
      if (!point.displacement.allFinite())
        refuse(support, "the displacement at (" + text(point.X.transpose()) + ") is not finite");
      locate(mesh, point);
      springs.points.push_back(point);
    }
    springs.supports.push_back({support.name, support.course});
  }
  build_matrices(mesh, springs);
  return springs;
}

Springs springs_on(const Springs& springs, const Mesh& mesh) {
  Springs result;
  if (springs.empty()) return result;
  result.points = springs.points;
  result.supports = springs.supports;
  for (Springs::Point& point : result.points) locate(mesh, point);
  build_matrices(mesh, result);
  return result;
}

std::vector<Eigen::Vector3d> anchors_at(const Springs& springs, double time) {
  std::vector<double> courses;
  for (const Springs::Support& support : springs.supports) courses.push_back(course_at(support, time));
  std::vector<Eigen::Vector3d> anchors;
  anchors.reserve(springs.points.size());
  for (const Springs::Point& point : springs.points) anchors.push_back(courses[point.support] * point.displacement);
  return anchors;
}

void add_spring_forces(const Springs& springs, const Mesh& mesh, const Eigen::Matrix3Xd& u, Eigen::Matrix3Xd& forces) {
  for (const Springs::Point& point : springs.points)
    spread(mesh, point, point.stiffness * value_at(mesh, point, u), forces);
}

Eigen::Matrix3Xd anchor_forces(const Springs& springs, const Mesh& mesh, const std::vector<Eigen::Vector3d>& anchors) {
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  for (std::size_t p = 0; p < springs.points.size(); ++p)
    spread(mesh, springs.points[p], springs.points[p].stiffness * anchors[p], forces);
  return forces;
}

double spring_energy(const Springs& springs, const Mesh& mesh, const Eigen::Matrix3Xd& u, double time) {
  if (springs.empty()) return 0.0;
  const std::vector<Eigen::Vector3d> anchors = anchors_at(springs, time);
  double energy = 0.0;
  for (std::size_t p = 0; p < springs.points.size(); ++p)
    energy += 0.5 * springs.points[p].stiffness * (value_at(mesh, springs.points[p], u) - anchors[p]).squaredNorm();
  return energy;
}

std::vector<BodyFreedom> free_rigid_motions(const BaseTopology& topology, const Mesh& mesh, const HangingNodes& hanging,
                                            const Supports& supports, const Springs& springs) {
  if (springs.empty()) return free_rigid_motions(topology, mesh, hanging, supports);
  // A held point counts as a clamped node of its own, in a cell that has shrunk onto it.
  Mesh with_points = mesh;
  HangingNodes nodes = hanging;
  Supports held = supports;
  const int points = static_cast<int>(springs.points.size());
  with_points.nodes.conservativeResize(3, mesh.node_count() + points);
  for (int p = 0; p < points; ++p) {
    const int node = mesh.node_count() + p, reduced = hanging.reduced_count() + p;
    with_points.nodes.col(node) = springs.points[p].X;
    with_points.cells.emplace_back().fill(node);
    with_points.frames.push_back({springs.points[p].at.base_cell, 0, {}});
    nodes.reduced_of.push_back(reduced);
    nodes.node_of.push_back(node);
    nodes.master.push_back(reduced);
    nodes.weight.push_back(1.0);
    nodes.row_start.push_back(static_cast<int>(nodes.master.size()));
    held.reduced.push_back(reduced);
    held.held.push_back(Eigen::Matrix3d::Identity());
  }
  std::vector<BodyFreedom> bodies = free_rigid_motions(topology, with_points, nodes, held);
  const std::vector<BodyFreedom> alone = free_rigid_motions(topology, mesh, hanging, supports);
  for (std::size_t body = 0; body < bodies.size(); ++body) bodies[body].cells = alone[body].cells;
  return bodies;
}

}  // namespace finegauge
