#include "core/mesh/body_location.hpp"

#include "core/mesh/immersed_body.hpp"
#include "core/mesh/immersed_location.hpp"

namespace finegauge {

std::optional<MaterialPoint> locate_in_body(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                            const Eigen::Vector3d& x, int hint) {
  std::optional<MaterialPoint> found = locate_deformed(mesh, u, x, hint);
  if (found && base.body && !contains(*base.body, rest_position(base, *found))) return std::nullopt;
  return found;
}

std::optional<SurfaceHit> first_body_entry(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                           const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return base.body ? first_immersed_entry(base, mesh, u, from, to) : first_entry(mesh, u, from, to);
}

std::optional<SurfaceHit> nearest_body_surface(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                               const Eigen::Vector3d& x, double reach) {
  return base.body ? nearest_immersed_surface_point(base, mesh, u, x, reach) : nearest_surface_point(mesh, u, x, reach);
}

std::optional<ChainMeeting> chain_meeting(const BaseMesh& base, const Mesh& mesh, const Eigen::Matrix3Xd& u,
                                          const Eigen::Matrix3Xd& chain) {
  const Eigen::Vector3d size = mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff();
  const double reach = location_slack * size.maxCoeff();
  const int count = static_cast<int>(chain.cols());
  for (const int end : {0, count - 1}) {
    const Eigen::Vector3d x = chain.col(end);
    if (nearest_body_surface(base, mesh, u, x, reach)) return ChainMeeting{ChainMeeting::Kind::on_surface, end, x};
    if (locate_in_body(base, mesh, u, x)) return ChainMeeting{ChainMeeting::Kind::inside, end, x};
  }
  for (int k = 0; k + 1 < count; ++k)
    if (const auto hit = first_body_entry(base, mesh, u, chain.col(k), chain.col(k + 1)))
      return ChainMeeting{ChainMeeting::Kind::enters, k, hit->position};
  return std::nullopt;
}

}  // namespace finegauge
