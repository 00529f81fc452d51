#include "verification/support/traction_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace finegauge {

Eigen::Matrix3Xd traction_forces(const BaseMesh& base, const Mesh& mesh, const std::string& surface,
                                 const TractionField& traction) {
  static const std::array<double, 3> points = {0.5 - 0.5 * std::sqrt(0.6), 0.5, 0.5 + 0.5 * std::sqrt(0.6)};
  constexpr std::array<double, 3> weights = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  const auto found = base.surfaces.find(surface);
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  int faces = 0;
  for (const BoundaryFace& face : mesh.boundary) {
    if (found == base.surfaces.end() || !std::binary_search(found->second.begin(), found->second.end(), face.base))
      continue;
    ++faces;
    const std::array<int, 4>& corners = hexahedron_faces[face.face];
    std::array<int, 4> nodes;
    Eigen::Matrix<double, 3, 4> X;
    for (int c = 0; c < 4; ++c) X.col(c) = mesh.nodes.col(nodes[c] = mesh.cells[face.cell][corners[c]]);
    // Corners run along the two other axes taken cyclically, so that the first along crossed with the second points up
    // the face's own axis: outward on the upper side.
    const double outward = face.face % 2 == 1 ? 1.0 : -1.0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double s = points[i], t = points[j];
        const Eigen::Vector4d N((1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t);
        const Eigen::Vector3d along_s = (1.0 - t) * (X.col(1) - X.col(0)) + t * (X.col(3) - X.col(2));
        const Eigen::Vector3d along_t = (1.0 - s) * (X.col(2) - X.col(0)) + s * (X.col(3) - X.col(1));
        const Eigen::Vector3d area = outward * along_s.cross(along_t);
        const Eigen::Vector3d force = weights[i] * weights[j] * area.norm() * traction(X * N, area.normalized());
        for (int c = 0; c < 4; ++c) forces.col(nodes[c]) += N[c] * force;
      }
  }
  if (faces == 0) throw std::invalid_argument("traction on surface '" + surface + "', which has no faces");
  return forces;
}

}  // namespace finegauge
