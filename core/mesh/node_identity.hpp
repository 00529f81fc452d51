#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/base_topology.hpp"
#include "core/mesh/mesh.hpp"

/// Which base entity a point of a base cell's lattice belongs to, and back. Not part of the interface of the mesh.
namespace finegauge {

NodeIdentity identity_of(const BaseMesh& base, const BaseTopology& topology, int base_cell, const LatticePoint& point);

/// Rest position [m], from the entity alone: the same bits whichever cell asks.
Eigen::Vector3d position_of(const BaseMesh& base, const BaseTopology& topology, const NodeIdentity& identity);

bool on_boundary(const BaseTopology& topology, const NodeIdentity& identity);

/// The point as each base cell around the entity sees it.
struct LocalPoint {
  int base_cell;
  LatticePoint point;
};
void local_points(const BaseMesh& base, const BaseTopology& topology, const NodeIdentity& identity,
                  std::vector<LocalPoint>& points);

constexpr int entity_dimension(const NodeIdentity& identity) { return static_cast<int>(identity.entity >> 32); }
constexpr int entity_index(const NodeIdentity& identity) { return static_cast<int>(identity.entity & 0xffffffffu); }

/// Numbers identities in the order of their first appearance.
class NodeNumbers {
 public:
  explicit NodeNumbers(std::size_t expected);
  /// The number of the identity, a new one if it was not seen before.
  int number(const NodeIdentity& identity);
  std::vector<NodeIdentity> take() { return std::move(identities_); }

 private:
  void grow();
  std::vector<NodeIdentity> identities_;
  std::vector<int> slots_;  // open addressing, a power of two, -1 where empty
};

}  // namespace finegauge
