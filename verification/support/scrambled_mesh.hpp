#pragma once

#include <random>

#include "core/mesh/base_mesh.hpp"

namespace finegauge {

/// The same body with its nodes renumbered at random and each cell's corners in a random order that keeps its
/// orientation (24 turns of the cube, 12 of the tetrahedron): neighbouring cells then see their common faces and edges
/// in different frames. Named surfaces stay what they were.
BaseMesh scrambled(const BaseMesh& mesh, std::mt19937& generator);

/// A box with each inner node moved by up to `share` of a lattice cell's edge along each axis; nodes on the box's
/// planes stay on them (those in a plane move along it), so that supports of planes still make sense.
BaseMesh distorted_box(const BoxMeshOptions& options, double share, std::mt19937& generator);

/// The seven cells of MacNeal & Harder (1985), solid patch test: a unit cube around an inner distorted cell.
/// Coordinates of the inner nodes as printed there. One cell's Jacobian is negative at a corner, though positive at its
/// quadrature points. Surface "outside" holds the six outer faces.
BaseMesh macneal_harder_patch();

}  // namespace finegauge
