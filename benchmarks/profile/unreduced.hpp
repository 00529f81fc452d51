#pragma once

#include "core/space/discretization.hpp"

namespace finegauge {

/// T of a mesh whose nodes are all taken for nodes that do not hang: the identity.
HangingNodes nodes_as_they_are(const Mesh& mesh);

/// A discretization without its T: each node its own unknowns, so that assembly gives the matrix before it is reduced
/// and a field may gape where nodes hang. What elementwise reduction is compared with; no solution on its own.
/// Supports hold the nodes that they held before and no hanging ones, which follow their masters.
Discretization unreduced(const Discretization& d);

}  // namespace finegauge
