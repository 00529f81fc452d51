#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/base_topology.hpp"
#include "core/mesh/hanging_nodes.hpp"
#include "core/mesh/mesh.hpp"

namespace finegauge {

/// A prescribed displacement on a named surface or in a named region: all of it (`normal` empty: clamped) or its
/// component along `normal`, any direction, not only the axes.
///
/// A region holds the part of the body over base nodes that are all in it (region.hpp, region_nodes), the same for
/// every refinement. Where the displacement is affine, or any field that the base cells can represent, refining and
/// coarsening there keeps the prescribed field exactly.
struct SupportCondition {
  std::string surface;                                                  ///< a key of BaseMesh::surfaces or ::regions
  std::optional<Eigen::Vector3d> normal;                                ///< direction held; need not have length one
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> displacement;  ///< of the rest position [m]; none: zero
  std::function<double(double)> course = {};  ///< factor of the displacement over time [s]; none: one, at all times
};

/// What one condition with a course adds to the prescribed displacements: course(t) × displacement.
struct SupportMotion {
  std::string surface;
  std::function<double(double)> course;
  std::vector<int> at;                        ///< entries of Supports, ascending
  std::vector<Eigen::Vector3d> displacement;  ///< at course = 1, merged with the conditions before [m]
};

/// The part of S that differs from the identity. For each supported node that does not hang: the projector onto the
/// held directions, and the displacement there. Free directions are what the projector leaves.
/// Unknowns keep three components per node that does not hang; matrices become Z A Z + κ H (H the projector, Z = I -
/// H), which for components along the axes is the customary "zero row and column, κ on the diagonal" and also holds for
/// inclined planes.
struct Supports {
  std::vector<int> reduced;                   ///< reduced node numbers, ascending
  std::vector<Eigen::Matrix3d> held;          ///< H, symmetric projector
  std::vector<Eigen::Vector3d> displacement;  ///< H-part of the prescribed displacement at t = 0 [m]
  std::vector<Eigen::Vector3d> resting;       ///< its part that does not move [m]; only beside motions
  std::vector<SupportMotion> motions;         ///< in the order of the conditions that have a course
};

/// Directions prescribed twice at one node are merged; where they contradict each other the first condition wins in
/// the directions that it holds. Merging is linear in the prescribed values and takes directions from the normals
/// alone, so that what moves can be told apart once and for all times. Throws std::invalid_argument when a surface or
/// region does not exist.
Supports find_supports(const BaseMesh& base, const Mesh& mesh, const HangingNodes& hanging,
                       const std::vector<SupportCondition>& conditions);

/// The H-part of the prescribed displacement at a time [m], per entry: Supports::displacement where nothing moves, and
/// at t = 0. `displacement` is overwritten; its buffer is used again. Throws std::invalid_argument where a course is
/// not finite.
void prescribe(const Supports& supports, double time, std::vector<Eigen::Vector3d>& displacement);

/// A part of the mesh whose cells hang together through faces, and what its supports leave of it.
struct BodyFreedom {
  int cells;               ///< leaves of the body
  Eigen::Vector3d inside;  ///< centre of its first leaf, at rest [m]
  int free_motions;        ///< rigid motions, of six
};

/// How many rigid motions the supports leave free at rest, body by body, ordered by their first cells. A static problem
/// needs zero everywhere. Cells that only share a node or an edge belong to different bodies: a hinge is no support, so
/// each side of it must be held by itself, at nodes of its own (those of the hinge are nodes of both). That is stricter
/// than need be where bodies hinged together hold each other.
std::vector<BodyFreedom> free_rigid_motions(const BaseTopology& topology, const Mesh& mesh, const HangingNodes& hanging,
                                            const Supports& supports);

}  // namespace finegauge
