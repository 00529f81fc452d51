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
/// whose estimate does without.
FreeSurface find_free_surface(const RefinementForest& forest, const Discretization& d,
                              const std::vector<SupportCondition>& supports, const std::vector<SurfaceLoad>& loads);

/// The projector onto the directions in which a stress may act at entry k, P with P n = 0 for the normals n of the
/// faces there: P σ P satisfies σ n = 0 and is, of all stresses that do, the closest to σ (in the Frobenius norm). The
/// facets of a curved surface count as one face, faces that bend by more than 37 degrees as two. `x`: positions of
/// nodes [m].
Eigen::Matrix3d free_directions(const FreeSurface& surface, std::size_t k, const Eigen::Matrix3Xd& x);

}  // namespace finegauge
