#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/mesh/point_location.hpp"

namespace finegauge {

/// The body where the displacement u (3 × n_nodes) has carried it, for who does not care what bounds it: the boundary
/// faces of the cells or, where the base mesh has an immersed body, that body's surface. `mesh` is a leaf mesh of a
/// forest on `base`.

/// The material point at x [m], if x is in the body. On the surface of an immersed body either answer is given; a body
/// of full cells has its surface, `location_slack` beyond included.
std::optional<MaterialPoint> locate_in_body(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                            const Eigen::Vector3d& x, int hint = -1);
/// first_entry of point_location.hpp.
std::optional<SurfaceHit> first_body_entry(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                           const Eigen::Vector3d& from, const Eigen::Vector3d& to);
/// nearest_surface_point of point_location.hpp.
std::optional<SurfaceHit> nearest_body_surface(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                               const Eigen::Vector3d& x, double reach);

/// Where a chain of points (3 × n [m], n >= 1) meets the body: an end of it that lies in the body or on its surface, or
/// the first way in on the chord from one point to the next. With both ends outside a chain that is anywhere in the
/// body has a way in.
struct ChainMeeting {
  enum class Kind { on_surface, inside, enters };
  Kind kind;
  int point;                 ///< of the chain; of `enters`: the one that the chord starts from
  Eigen::Vector3d position;  ///< [m]
};
/// An end is on the surface when that is within `location_slack` of the mesh's size.
std::optional<ChainMeeting> chain_meeting(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                          const Eigen::Matrix3Xd& chain);

}  // namespace finegauge
