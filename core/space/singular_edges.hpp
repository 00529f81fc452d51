#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/base_topology.hpp"
#include "core/mesh/mesh.hpp"
#include "core/space/supports.hpp"

namespace finegauge {

/// Edges of the body along which the stress of the exact solution is in general unbounded, u ~ r^λ with λ < 1
/// (Williams 1952): by the angle ω of the material there, and by what holds the two faces that meet,
///
/// - both free, or both clamped: ω > π (a notch);
/// - one free, one clamped: sin ω > √(1 - nu) (the rim of a clamped face; λ = 1 at equality);
/// - one a roller, the other free or clamped: ω > π/2 (mirrored at the roller: 2 ω);
/// - both rollers: ω > π/2, but not ω = π.
///
/// Only what is π/12 beyond these counts, so that the facets of a curved surface do not: in a notch λ is 0.86 there.
///
/// A face counts as clamped when a condition on its surface holds all directions, as a roller when one holds its normal
/// alone. Conditions on regions of nodes are not seen, nor is the surface of an immersed body: its walls are those of a
/// lattice, not the body's.
///
/// Per leaf of a hexahedral mesh the fewest base cells around such an edge that the leaf touches: 0 where it touches
/// none, 1 at a convex edge, 2 at a flat one, 3 in a notch. All zero for tetrahedra.
std::vector<std::uint8_t> cells_at_singular_edges(const BaseMesh& base, const BaseTopology& topology, const Mesh& mesh,
                                                  const std::vector<SupportCondition>& supports, double poisson_ratio);

}  // namespace finegauge
