#pragma once

#include "core/mesh/immersed_body.hpp"

namespace finegauge {

/// Where the share of material of a cell, base cell or leaf, is decided; nobody else does.
///
/// The share is exact for the polyhedron but for round-off: the divergence theorem with the field
/// F = (0, 0, clamp(z, z0, z1) - z0), whose divergence is one between the heights z0 and z1 of the box and zero
/// elsewhere, over the surface inside the box's column,
///     V = ∮ F·n dA;
/// what lies below the box gives 0, beside it ∫ (z - z0) n_z dA, above it (z1 - z0) ∫ n_z dA, and the walls of the
/// column, where the body is cut, have n_z = 0. No point is asked whether it lies inside. Looked at upside down the
/// same is summed over what lies below instead; boxes in the lower half are, since there is less of it.
///
/// The cut points of an edge are the same bits for both triangles at it, so that what must cancel does, up to the
/// order of summation: a box without surface comes out as 0 or 1 within about 1e-16 times the triangles over it,
/// however large these are beside the box.

/// Shares this close to 0 or 1 are made exactly that: some hundred times the round-off of a column of a hundred
/// triangles, and less material than could matter to anything. Whole cells are whole then, a cell without material is
/// known as such, and both pass that on to their children without another integral.
inline constexpr double full_or_empty = 1e-12;

/// The box of a leaf or base cell in lattice coordinates (immersed_body.hpp). Neighbours get the bits of their common
/// plane from the same integers.
BoundingBox lattice_box(const ImmersedBody& body, const LeafFrame& frame);

/// Share of the box's volume that lies in the body, as the integral gives it. The box has a positive volume and lies
/// in one lattice cell. [lattice coordinates]
double integrated_share(const ImmersedBody& body, const BoundingBox& box);

/// The same made 0 or 1 exactly where it is full_or_empty, for a leaf of any refinement. Never outside [0, 1]: a
/// surface that encloses points twice or from outside, which is not a body, has no shares to speak of; immersed_mesh
/// refuses it where a base cell shows it. A leaf too deep for its edges to show in its coordinates (halved some forty
/// times) is all in or all out.
double material_share(const ImmersedBody& body, const LeafFrame& frame);
double rounded_share(double integrated);

/// Where in the box the material lies, from integrals of the same kind: with f one of the six (MaterialMeans),
/// F = (0, 0, ∫ f dz from z0 to clamp(z, z0, z1)). Precondition as there, and the share is neither 0 nor 1.
MaterialMeans integrated_means(const ImmersedBody& body, const BoundingBox& box);
/// Those of a leaf whose share is given; within [0, 1] each. A leaf too deep to integrate (material_share) is taken as
/// full.
MaterialMeans material_means(const ImmersedBody& body, const LeafFrame& frame, double share);

}  // namespace finegauge
