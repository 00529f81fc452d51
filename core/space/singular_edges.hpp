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
struct SingularEdge {
  /// Base cells around the edge, tetrahedra by twos: 1 at a convex edge, 2 at a flat one, 3 in a notch, 4 (or more) at
  /// a crack; 0: there is no edge. Hexahedra that are wider than 5π/9 in the mean count as one, since they follow the
  /// field no better than a single one. Of tetrahedra a notch may have two as well.
  std::uint8_t cells = 0;
  std::uint8_t exponent_64ths = 0;  ///< λ, rounded down
  bool lies_along = false;          ///< a tetrahedron with an edge there, not with a corner alone
  bool within = false;  ///< a tetrahedron with no other corner on base faces that meet at such edges, rollers apart

  double exponent() const { return (exponent_64ths + 0.5) / 64.0; }  ///< λ, in (0, 1)
  explicit operator bool() const { return cells != 0; }
  bool operator==(const SingularEdge&) const = default;
};
/// Whether of two edges that a cell touches the first one counts: the one with the fewest cells, of these that with the
/// least λ.
bool counts_before(const SingularEdge& a, const SingularEdge& b);

/// Per leaf the edge that it touches: a hexahedron with an edge of its own, a tetrahedron with a corner, since those
/// that wedge in between the ones with edges there see the same stress and are twice as many. None in immersed bodies.
std::vector<SingularEdge> singular_edges_of_cells(const BaseMesh& base, const BaseTopology& topology, const Mesh& mesh,
                                                  const std::vector<SupportCondition>& supports, double poisson_ratio);

/// Per node whether it lies on one.
std::vector<std::uint8_t> nodes_on_singular_edges(const BaseMesh& base, const BaseTopology& topology, const Mesh& mesh,
                                                  const std::vector<SupportCondition>& supports, double poisson_ratio);

/// What holds the two faces that meet at an edge.
enum class FaceHold { free, roller, clamped };
/// The least λ in (1/4, 1) of u ~ r^λ at an edge with the angle ω [rad] of material; 1/2 where all are complex, as at
/// the end of a clamped part of a flat face. κ = 3 - 4 nu, signs of the modes that are singular first:
///
/// - both free, or both clamped: q sin λω = -λ sin ω, q = 1 or κ;
/// - one free, one clamped: sin² λω = ((κ + 1)² - 4 λ² sin² ω) / 4κ;
/// - one a roller: the edge mirrored at it.
double edge_exponent(FaceHold a, FaceHold b, double angle, double poisson_ratio);

}  // namespace finegauge
