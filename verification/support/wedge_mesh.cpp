#include "verification/support/wedge_mesh.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace finegauge {

namespace {

/// Numbers of the nodes in one plane: the edge, then the rays from within, then the inner nodes of the blocks.
struct PlaneNumbers {
  int blocks, n;
  int count() const { return 1 + (blocks + 1) * n + blocks * n * n; }
  /// The node i steps along the block's first ray and j along its second.
  int operator()(int block, int i, int j) const {
    if (i == 0 && j == 0) return 0;
    if (j == 0) return block * n + i;
    if (i == 0) return (block + 1) * n + j;
    return (blocks + 1) * n + block * n * n + (j - 1) * n + i;
  }
};

}  // namespace

BaseMesh wedge_mesh(const WedgeOptions& options) {
  const auto [opening, blocks, n, layers, height] = options;
  if (!(opening > 0.0 && opening <= 2.0 * std::numbers::pi && opening < std::numbers::pi * blocks))
    throw std::invalid_argument("wedge_mesh: the opening must be above 0 and at most 2 pi, below pi in each block");
  const PlaneNumbers number{blocks, n};
  BaseMesh mesh;
  mesh.nodes.resize(3, static_cast<Eigen::Index>(number.count()) * (layers + 1));
  const auto ray = [&](int k) {
    const double angle = k * options.opening / options.blocks;
    return Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
  };
  for (int block = 0; block < blocks; ++block)
    for (int k = 0; k <= layers; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
          mesh.nodes.col(k * number.count() + number(block, i, j)) =
              (i * ray(block) + j * ray(block + 1)) / n + Eigen::Vector3d(0.0, 0.0, height * k / layers);
  for (int block = 0; block < blocks; ++block)
    for (int k = 0; k < layers; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const int cell = static_cast<int>(mesh.cells.size());
          auto& corners = mesh.cells.emplace_back();
          for (int c = 0; c < 8; ++c)
            corners[c] = (k + (c >> 2)) * number.count() + number(block, i + (c & 1), j + ((c >> 1) & 1));
          if (block == blocks - 1 && i == 0) mesh.surfaces["ray_last"].push_back({cell, 0});
          if (i == n - 1) mesh.surfaces["outer"].push_back({cell, 1});
          if (block == 0 && j == 0) mesh.surfaces["ray_first"].push_back({cell, 2});
          if (j == n - 1) mesh.surfaces["outer"].push_back({cell, 3});
          if (k == 0) mesh.surfaces["z_min"].push_back({cell, 4});
          if (k == layers - 1) mesh.surfaces["z_max"].push_back({cell, 5});
        }
  return mesh;
}

}  // namespace finegauge
