#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/space/discretization.hpp"
#include "core/space/loads.hpp"

namespace finegauge {

/// Where σ n = 0 is known of the stress: the nodes, not hanging, around which the boundary of a body of tetrahedra is
/// free of supports and loads, but for faces that are held and say nothing there (a roller beside a free face). Not on
/// singular edges, where the stress has no value. None where springs may pull anywhere, nor in bodies of hexahedra,
/// whose estimate does without. `loads` must be all that act: a needle's are not among them, so that bodies at rest
/// have a free surface and moving ones none.
FreeSurface find_free_surface(const RefinementForest& forest, const Discretization& d,
                              const std::vector<SupportCondition>& supports, const std::vector<SurfaceLoad>& loads);

/// Per node of the discretization's free surface, as it lies at the displacement u [m]: the projector P onto the
/// directions in which a stress may act there, P n = 0 for the normals n of its faces. P σ P satisfies σ n = 0 and is,
/// of all stresses that do, the closest to σ (in the Frobenius norm).
///
/// Faces count by their angles at the node, which no refinement and no stretch of a plane changes. Where two planes
/// with as much angle each bend by less than 37 degrees, or fold back by more than 143, they count as one, in the mean:
/// so do the facets of a curved surface.
std::vector<Eigen::Matrix3d> free_directions(const Discretization& d, const Eigen::Matrix3Xd& u);

}  // namespace finegauge
