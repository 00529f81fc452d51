#include "verification/support/conformity.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include "core/mesh/nested_meshes.hpp"
#include "core/mesh/node_identity.hpp"

namespace finegauge {
namespace {

/// Whether a point is in a closed leaf, from its natural coordinates there. Points are drawn away from the leaf's
/// boundary or on it, so a tolerance of round-off decides rightly.
bool inside(CellShape shape, const Eigen::Vector3d& xi) {
  constexpr double tolerance = 1e-12;
  if (xi.minCoeff() < -tolerance) return false;
  return shape == CellShape::hexahedron ? xi.maxCoeff() <= 1.0 + tolerance : xi.sum() <= 1.0 + tolerance;
}

Eigen::Vector3d interpolate(const Mesh& mesh, int cell, const Eigen::Vector3d& xi, const Eigen::Matrix3Xd& nodal) {
  const auto N = shape_functions(mesh.shape, xi);
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (int c = 0; c < corner_count(mesh.shape); ++c) value += N[c] * nodal.col(mesh.cells[cell][c]);
  return value;
}

}  // namespace

double largest_jump(const RefinementForest& forest, const Mesh& mesh, const Eigen::Matrix3Xd& nodal,
                    int points_per_face, std::uint64_t seed) {
  std::vector<std::vector<int>> cells_of_base(forest.base().cells.size());
  for (int cell = 0; cell < mesh.cell_count(); ++cell) cells_of_base[mesh.frames[cell].base_cell].push_back(cell);
  std::mt19937_64 random(seed);
  std::vector<LocalPoint> seen_from;
  double jump = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int face = 0; face < face_count(mesh.shape); ++face)
      for (int k = 0; k < points_per_face; ++k) {
        // A combination of the face's corners in 64ths of the leaf; every fourth point lies on an edge.
        LatticePoint point{};
        std::array<std::uint64_t, 2> s = {random() % 65, random() % 65};
        if (k % 4 == 0) s[0] = 0;
        const LeafFrame& leaf = mesh.frames[cell];
        if (mesh.shape == CellShape::hexahedron) {
          const int axis = face / 2;
          for (int i = 0; i < 3; ++i) point[i] = leaf.corners[0][i];
          if (face % 2) point[axis] += leaf.corners[1][axis];
          for (int i = 0; i < 2; ++i) {
            const int other = (axis + 1 + i) % 3;
            point[other] += leaf.corners[1][other] / 64 * s[i];  // corners below 64 units are not drawn in tests
          }
        } else {
          if (s[0] + s[1] > 64) s = {64 - s[0], 64 - s[1]};
          const std::array<std::uint64_t, 3> weight = {64 - s[0] - s[1], s[0], s[1]};
          const auto& corners = face_corners(mesh.shape, face);
          for (int i = 0; i < 3; ++i)
            for (int axis = 0; axis < 3; ++axis) point[axis] += leaf.corners[corners[i]][axis] / 64 * weight[i];
        }
        const Eigen::Vector3d here = interpolate(mesh, cell, natural_coordinates(mesh.shape, leaf, point), nodal);
        local_points(forest.base(), forest.topology(),
                     identity_of(forest.base(), forest.topology(), leaf.base_cell, point), seen_from);
        for (const auto& [base_cell, local] : seen_from)
          for (const int other : cells_of_base[base_cell]) {
            const Eigen::Vector3d xi = natural_coordinates(mesh.shape, mesh.frames[other], local);
            if (inside(mesh.shape, xi))
              jump = std::max(jump, (interpolate(mesh, other, xi, nodal) - here).cwiseAbs().maxCoeff());
          }
      }
  return jump;
}

}  // namespace finegauge
