#pragma once

#include "core/mesh/base_mesh.hpp"

namespace finegauge {

/// Each hexahedron in six tetrahedra around its diagonal from corner 0 to corner 7 (Kuhn), as box_mesh splits its own;
/// surfaces keep their names. Throws std::invalid_argument where neighbours would cut a face along different diagonals,
/// which those whose axes all run alike do not.
BaseMesh tetrahedra_of(const BaseMesh& hexahedra);

}  // namespace finegauge
