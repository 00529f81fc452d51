#pragma once

#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/mesh.hpp"

namespace finegauge {

/// Where a body is attached, at rest [m]: inside a box or a sphere, edges included (to 1e-9 of the body's diagonal,
/// far above the rounding of coordinates in a file), or a patch of the surface: what lies within `radius` of the point
/// of the surface that is nearest to `point`.
struct BoxSelection {
  Eigen::Vector3d min, max;
};
struct SphereSelection {
  Eigen::Vector3d centre;
  double radius;
};
struct PatchSelection {
  Eigen::Vector3d point;
  double radius;
};
using Selection = std::variant<BoxSelection, SphereSelection, PatchSelection>;

/// Ascending numbers of what was selected, and how far outside of the selection the nearest candidate is [m]: zero
/// where something was selected.
struct Selected {
  std::vector<int> numbers;
  double nearest_outside = 0.0;
};

/// Nodes of the base mesh, to be a region of it. Box and sphere select by rest position; a patch selects the nodes of
/// the base cells that its triangles touch (immersed body: the cells' nodes lie beside the surface) or those of its
/// boundary faces (any other mesh).
Selected select_nodes(const BaseMesh& base, const Selection& selection);

/// The nodes of a leaf mesh at which a function that vanishes at the region's base nodes has to vanish whatever it is
/// elsewhere: those where no base node outside of the region has a shape function that is not zero. By whole numbers
/// (LeafFrame), no coordinates compared. So the part of the body that a region holds is the same for every refinement:
/// base cells, faces and edges all of whose corners are in it. Ascending.
std::vector<int> region_nodes(const BaseMesh& base, const Mesh& mesh, const std::vector<int>& region);

}  // namespace finegauge
