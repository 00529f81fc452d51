#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/base_topology.hpp"
#include "core/mesh/mesh.hpp"

namespace finegauge {

/// A rectangle that the face of one leaf shares with that of another, or the whole face of a leaf on the boundary of
/// the body. Side 0 is the leaf whose outward normal is the patch's.
///
/// Patch coordinates (s, t) run over [0, 1]²; on either side the natural coordinates are origin + s along_s + t
/// along_t. Both sides give the same place, exactly up to the rounding of the map.
struct FacePatch {
  struct Side {
    int cell = -1;  ///< leaf; -1 outside the body
    int face = -1;  ///< local face (cell_shape.hpp)
    Eigen::Vector3d origin = Eigen::Vector3d::Zero(), along_s = Eigen::Vector3d::Zero(),
                    along_t = Eigen::Vector3d::Zero();
    Eigen::Vector3d natural(double s, double t) const { return origin + s * along_s + t * along_t; }
  };
  std::array<Side, 2> sides;
  BaseFace base{-1, -1};  ///< on the boundary of the body, the base face that the patch is part of
};

/// How the faces of a hexahedral mesh's leaves meet, found by whole numbers on the lattice: a face against one equal to
/// it is one patch, a face against smaller ones a patch for each, and a face split in two against one split in three
/// the four rectangles that both lie in. Patches of a leaf tile its faces. Ordered by the mesh, then by place.
std::vector<FacePatch> face_patches(const BaseTopology& topology, const Mesh& mesh);

}  // namespace finegauge
