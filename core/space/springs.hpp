#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/mesh/point_location.hpp"
#include "core/space/supports.hpp"

namespace finegauge {

/// A point of the body held by a spring.
struct SpringPoint {
  MaterialPoint at;
  double stiffness = 0.0;  ///< k [N/m], > 0, the same in all directions
};
/// Springs of no length between points of the body and anchors, which may move: at a point X the body feels the force
///   f = -k (u(X) - a(t)),  a(t) = course(t) × displacement(X),
/// and where a step damps by β K the force -β k (u̇ - ȧ) as well, so that a body that goes with its anchors is not held
/// back. They are fixed in space: the directions of f do not turn with the cells.
struct SpringSupport {
  std::string name;
  std::vector<SpringPoint> points;
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> displacement;  ///< of the rest position [m]; none: zero
  std::function<double(double)> course = {};                            ///< over time [s]; none: one, at all times
};

/// For who asks for forces or energies of springs without saying when. Where an anchor has a course it is refused
/// (std::invalid_argument); elsewhere all times are alike.
inline constexpr double no_time = std::numeric_limits<double>::quiet_NaN();

/// Σ k N_a N_b over the springs of a cell [N/m]: what each component of its corners feels.
using SpringMatrix = Eigen::Matrix<double, max_corners, max_corners>;

/// The springs on a mesh: what a Discretization knows of them.
struct Springs {
  struct Point {
    int support;  ///< entry of `supports`
    MaterialPoint at;
    double stiffness;              ///< k [N/m]
    Eigen::Vector3d X;             ///< at rest [m]
    Eigen::Vector3d displacement;  ///< of the anchor at course = 1 [m]
    int cell;                      ///< leaf that contains it
    Eigen::Vector3d xi;            ///< natural coordinates there
    std::array<double, max_corners> N;
  };
  struct Support {
    std::string name;
    std::function<double(double)> course;
  };
  std::vector<Point> points;  ///< in the order of the supports and of their points
  std::vector<Support> supports;
  std::vector<int> matrix_number;      ///< per cell, -1 where it has no spring; empty without springs
  std::vector<SpringMatrix> matrices;  ///< of the cells that have some

  bool empty() const { return points.empty(); }
  /// Of a cell; none where it has no springs.
  const SpringMatrix* matrix_of(int cell) const {
    return matrix_number.empty() || matrix_number[cell] < 0 ? nullptr : &matrices[matrix_number[cell]];
  }
};

/// Throws std::invalid_argument with the support's name, value and range where a point is outside of the mesh, k not
/// finite and > 0, or a displacement not finite.
Springs find_springs(const BaseMesh& base, const Mesh& mesh, const std::vector<SpringSupport>& supports);
/// The same springs on another mesh of the same forest.
Springs springs_on(const Springs& springs, const Mesh& mesh);

/// Displacements of the anchors at a time, per point [m]. Throws std::invalid_argument where a course is not finite.
std::vector<Eigen::Vector3d> anchors_at(const Springs& springs, double time);

/// forces += k N_a u(X), nodal: the force [N] that springs whose anchors stay at rest are stretched by. `u` [m] may as
/// well be a velocity; then it is K v.
void add_spring_forces(const Springs& springs, const Mesh& mesh, const Eigen::Matrix3Xd& u, Eigen::Matrix3Xd& forces);
/// Nodal forces k N_a a_p [N], 3 × n_nodes, of what anchors (or whatever stands for them) bring per point.
Eigen::Matrix3Xd anchor_forces(const Springs& springs, const Mesh& mesh, const std::vector<Eigen::Vector3d>& anchors);
/// 1/2 Σ k |u - a|² [J].
double spring_energy(const Springs& springs, const Mesh& mesh, const Eigen::Matrix3Xd& u, double time);

/// As free_rigid_motions (supports.hpp), where a spring holds its point in all directions.
std::vector<BodyFreedom> free_rigid_motions(const BaseTopology& topology, const Mesh& mesh, const HangingNodes& hanging,
                                            const Supports& supports, const Springs& springs);

}  // namespace finegauge
