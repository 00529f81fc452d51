#include "benchmarks/profile/chain_lengths.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/mesh/node_identity.hpp"

namespace finegauge {
namespace {

class ChainSearch {
 public:
  ChainSearch(const RefinementForest& forest, const Mesh& mesh, const HangingNodes& hanging)
      : forest_(forest), mesh_(mesh), hanging_(hanging), lengths_(mesh.node_count(), unknown) {
    leaves_of_.resize(forest.base().cells.size());
    for (int cell = 0; cell < mesh.cell_count(); ++cell) leaves_of_[mesh.frames[cell].base_cell].push_back(cell);
  }

  std::vector<int> find() {
    for (int node = 0; node < mesh_.node_count(); ++node) length(node);
    return std::move(lengths_);
  }

 private:
  static constexpr int unknown = -1, open = -2;

  int length(int node) {
    int& known = lengths_[node];
    if (known == open) throw std::runtime_error("hanging nodes are masters of one another");
    if (known != unknown) return known;
    if (!hanging_.hangs(node)) return known = 0;
    known = open;
    int longest = 0;
    for (const int master : masters(node)) longest = std::max(longest, length(master));
    return lengths_[node] = longest + 1;
  }

  /// Corners with a weight, of the largest leaf that contains the node without having it as a corner.
  std::vector<int> masters(int node) {
    local_points(forest_.base(), forest_.topology(), mesh_.identities[node], points_);
    std::vector<int> corners;
    double largest = 0.0;
    for (const auto& [base_cell, point] : points_)
      for (const int leaf : leaves_of_[base_cell]) {
        const LatticePoint &lower = mesh_.frames[leaf].corners[0], &edges = mesh_.frames[leaf].corners[1];
        bool inside = true, corner = true;
        double size = 1.0;
        for (int axis = 0; axis < 3; ++axis) {
          // Not lower + edge, which may pass the last whole number.
          inside = inside && point[axis] >= lower[axis] && point[axis] - lower[axis] <= edges[axis];
          corner = corner && (point[axis] == lower[axis] || point[axis] - lower[axis] == edges[axis]);
          size *= static_cast<double>(edges[axis]) / static_cast<double>(lattice_unit(mesh_.shape));
        }
        if (!inside || corner || size <= largest) continue;
        largest = size;
        corners.clear();
        for (int c = 0; c < 8; ++c) {
          bool weighs = true;  // not on the side across from the corner
          for (int axis = 0; axis < 3; ++axis) {
            const bool upper = (c >> axis & 1) != 0;
            weighs = weighs && point[axis] - lower[axis] != (upper ? 0 : edges[axis]);
          }
          if (weighs) corners.push_back(mesh_.cells[leaf][c]);
        }
      }
    return corners;
  }

  const RefinementForest& forest_;
  const Mesh& mesh_;
  const HangingNodes& hanging_;
  std::vector<std::vector<int>> leaves_of_;  // per base cell
  std::vector<int> lengths_;
  std::vector<LocalPoint> points_;
};

}  // namespace

std::vector<int> chain_lengths(const RefinementForest& forest, const Mesh& mesh, const HangingNodes& hanging) {
  if (mesh.shape != CellShape::hexahedron)
    throw std::invalid_argument("chain lengths: found a mesh of tetrahedra, allowed are hexahedra");
  return ChainSearch(forest, mesh, hanging).find();
}

std::vector<int> chain_histogram(const std::vector<int>& lengths) {
  std::vector<int> histogram(1, 0);
  for (const int length : lengths) {
    if (length >= static_cast<int>(histogram.size())) histogram.resize(length + 1, 0);
    ++histogram[length];
  }
  return histogram;
}

}  // namespace finegauge
